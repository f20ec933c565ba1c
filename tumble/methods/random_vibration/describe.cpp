#include "tumble/methods/random_vibration/describe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/core/columns.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::random_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;

/// Change of the rest over a vibration: [sd] p = 2e-9, and [1] of the shift under vibration.
constexpr double rest_changes_sd = 6.0, rest_changes_share = 0.5;
/// [sd of an extreme] by which peaks are higher or lower than those of a normal process. Higher: the distribution of
/// extremes has its longer tail there.
constexpr double peaks_high_sd = 5.0, peaks_low_sd = 4.0, peaks_apart_sd = 6.0;
/// Clipping: [1] of the shift's own uncertainty, 0.1 % of the shift added, and [1] of the time, below which it has no
/// effect.
constexpr double clip_of_own = 0.3, own_of_shift = 1e-3, clipped_time = 1e-5;
constexpr double size_differs = 0.03, size_differs_sd = 4.0;  ///< [1] of the rms, and [sd]

constexpr std::size_t most_points = 2000;

std::string name_of(const Data& data, const Measured& unit) { return data.units[unit.unit].name; }

std::string type_of(const Measured& unit, const std::vector<Type>& types) {
  for (const Type& type : types)
    if (std::ranges::find(type.units, unit.unit) != type.units.end()) return type.name;
  return "";
}

/// [m/s^2] of the real motion in the windows: by the reference, else by the density, docs/equations (3.13).
double motion_sd(const Exposure& exposure, const Measured& unit) {
  if (!unit.own.empty()) return std::sqrt(std::max(0.0, unit.sd * unit.sd - unit.own_sd * unit.own_sd));
  return std::sqrt(window_variance(exposure.psd, exposure.window)) * exposure.rms / std::sqrt(variance(exposure.psd));
}

double counting_sd(const Exposure& exposure, const Data& data, const Measured& unit) {
  return std::sqrt(pulses::rounding_variance(data.units[unit.unit].pulse, exposure.window));
}

/// Spread without motion and rounding; NaN where only the density is known and hides it.
double own_sd(const Exposure& exposure, const Data& data, const Measured& unit) {
  const double counting = counting_sd(exposure, data, unit);
  if (!unit.own.empty()) return std::sqrt(std::max(0.0, unit.own_sd * unit.own_sd - counting * counting));
  return std::nan("");
}

std::string place_of(const Exposure& exposure, const Data& data, const Measured& unit) {
  const auto& under_test = data.units[unit.unit];
  return under_test.prefix.empty() ? exposure.label : under_test.name + ", " + exposure.label;
}

void report_motion(const Exposure& exposure, const Data& data, Findings& findings) {
  const Measured& unit = exposure.units.front();
  const double motion = motion_sd(exposure, unit);
  if (!unit.own.empty())
    findings.push_back({Severity::info,
                        "motion_in_reference",
                        {{"share", std::pow(motion / unit.sd, 2), "%"}, {"unit", name_of(data, unit)}},
                        exposure.label});
  else
    findings.push_back({Severity::info,
                        exposure.reference.empty() ? "spread_is_motion" : "spread_is_motion_beside_instants",
                        {{"motion", motion, "g"}, {"unit", name_of(data, unit)}, {"shown", unit.sd, "g"}},
                        exposure.label});
}

void report_rest(const std::string& where, const Measured& unit, Findings& findings) {
  if (!unit.rest.both_sides)
    findings.push_back(
        {Severity::warning, std::isnan(unit.rest.before) ? "rest_only_after" : "rest_only_before", {}, where});
  const double change = unit.rest.after - unit.rest.before;
  if (std::abs(change) > rest_changes_sd * std::sqrt(unit.rest.variance + unit.rest.slow_variance) &&
      std::abs(change) > rest_changes_share * std::abs(unit.mean))
    findings.push_back(
        {Severity::warning, "rest_changes", {{"change", change, "mg"}, {"shift", unit.mean, "mg"}}, where});
}

/// Peaks compared with those of a normal process.
void report_peaks(const std::string& where, const Measured& unit, Findings& findings) {
  const Extreme extreme = greatest_of(static_cast<double>(unit.windows));
  const double middle = 0.5 * (unit.highest + unit.lowest), half = 0.5 * (unit.highest - unit.lowest);
  const double expected = extreme.mean * unit.sd, sd = extreme.sd * unit.sd / std::numbers::sqrt2;
  if (half > expected + peaks_high_sd * sd || half < expected - peaks_low_sd * sd)
    findings.push_back({Severity::warning,
                        half > expected ? "peaks_too_high" : "peaks_too_low",
                        {{"ratio", 2.0 * half / unit.sd}, {"normal", 2.0 * extreme.mean}, {"windows", unit.windows}},
                        where});
  if (std::abs(middle) > peaks_apart_sd * sd)
    findings.push_back({Severity::warning,
                        "peaks_not_symmetric",
                        {{"highest", unit.highest / unit.sd}, {"lowest", unit.lowest / unit.sd}},
                        where});
}

void report_clipping(const Exposure& exposure, const Data& data, const Measured& unit, Findings& findings) {
  if (!data.range) return;
  const Clipping clip = clipping(unit.rest.value, exposure.rms, *data.range);
  const double own = std::sqrt(unit.rest.variance) + own_of_shift * std::abs(unit.mean);
  if (std::abs(clip.shift) < clip_of_own * own && clip.share < clipped_time) return;
  findings.push_back({Severity::warning,
                      "unit_clips",
                      {{"rms", exposure.rms, "g"},
                       {"rest", unit.rest.value, "g"},
                       {"share", clip.share, "%"},
                       {"range", *data.range, "g"},
                       {"shift", clip.shift, "mg"},
                       {"part", clip.shift / unit.mean, "%"}},
                      place_of(exposure, data, unit)});
}

/// What a unit shows of the vibration.
struct Size {
  double ratio = 1.0, uncertainty = 0.0;  ///< [1]
  bool by_reference = false;
};

/// The spread over that of the vibration: of the reference, else as commanded.
Size size_of(const Exposure& exposure, const Data& data, const Measured& unit, const Estimate& estimate) {
  const auto& under_test = data.units[unit.unit];
  if (!unit.own.empty())
    return {unit.sense * unit.reference_gain, std::hypot(exposure.gain_sd, under_test.scale_relative_sd), true};
  const double expected =
      std::sqrt(window_variance(exposure.psd, exposure.window) * exposure.rms * exposure.rms / variance(exposure.psd) +
                unit.rest.white + std::pow(counting_sd(exposure, data, unit), 2));
  const auto* sd = find_parameter(estimate, exposure.prefix + under_test.prefix + "pulse_error_sd");
  const auto index = static_cast<std::size_t>(sd - estimate.parameters.data());
  return {unit.sd / expected,
          std::hypot(standard_uncertainty(estimate, index) / sd->value, under_test.scale_relative_sd), false};
}

void report_size(const Exposure& exposure, const Data& data, const Measured& unit, const Estimate& estimate,
                 Findings& findings) {
  const Size size = size_of(exposure, data, unit, estimate);
  if (std::abs(size.ratio - 1.0) > std::max(size_differs, size_differs_sd * size.uncertainty))
    findings.push_back({Severity::warning,
                        size.by_reference ? "vibration_differs_from_reference" : "vibration_differs_from_plan",
                        {{"ratio", size.ratio}, {"uncertainty", size.uncertainty, "%"}},
                        place_of(exposure, data, unit)});
}

}  // namespace

/// A unit in one vibration.
struct UnitRow {
  const Exposure& exposure;
  const Measured& unit;
  std::string prefix;  ///< of its parameters
  double k;            ///< [shown/(m/s^2)]
};

/// Units that count beside units that do not: only a specific force compares.
bool all_count(const Data& data) {
  return std::ranges::all_of(data.units, [](const auto& u) { return u.pulse > 0.0; });
}

std::vector<UnitRow> unit_rows(const std::vector<Exposure>& exposures, const Data& data) {
  const bool counted = all_count(data);
  std::vector<UnitRow> rows;
  for (const Exposure& exposure : exposures)
    for (const Measured& unit : exposure.units)
      rows.push_back({exposure, unit, exposure.prefix + data.units[unit.unit].prefix, counted ? unit.per_force : 1.0});
  return rows;
}

Table units_table(const std::vector<Exposure>& exposures, const Data& data, const std::vector<Type>& types,
                  const Estimate& estimate) {
  using Row = UnitRow;
  const Unit error = Unit::parse(all_count(data) ? "pulse" : "mg");
  const auto mean_sd = [&](const Row& r) {
    const auto* mean = find_parameter(estimate, r.prefix + "pulse_error_mean");
    const auto index = static_cast<std::size_t>(mean - estimate.parameters.data());
    return r.k / r.unit.per_force * standard_uncertainty(estimate, index);
  };
  const auto normal = [](const Row& r) {
    return 2.0 * greatest_of(static_cast<double>(r.unit.windows)).mean * r.unit.sd;
  };
  return tabulate(
      "units", "the units side by side: pulse error, its part from the motion, from counting, and their own",
      unit_rows(exposures, data),
      {{"unit", [&](const Row& r) { return name_of(data, r.unit); }},
       {"type", [&](const Row& r) { return type_of(r.unit, types); }},
       {"vibration", [](const Row& r) { return r.exposure.label; }},
       {"windows", [](const Row& r) { return r.unit.windows; }},
       {"a_0", "g", [](const Row& r) { return r.unit.rest.value; }},
       {"rest_before", "g", [](const Row& r) { return r.unit.rest.before; }},
       {"rest_after", "g", [](const Row& r) { return r.unit.rest.after; }},
       {"plain_mean", error, [](const Row& r) { return r.k * r.unit.plain_mean; }},
       {"mean", error, [](const Row& r) { return r.k * r.unit.mean; }},
       {"mean_sd", error, mean_sd},
       {"sd", error, [](const Row& r) { return r.k * r.unit.sd; }},
       {"sd_from_motion", error, [](const Row& r) { return r.k * motion_sd(r.exposure, r.unit); }},
       {"sd_from_counting", error, [&](const Row& r) { return r.k * counting_sd(r.exposure, data, r.unit); }},
       {"sd_own", error, [&](const Row& r) { return r.k * own_sd(r.exposure, data, r.unit); }},
       {"peak_to_peak", error, [](const Row& r) { return r.k * (r.unit.highest - r.unit.lowest); }},
       {"normal_peak_to_peak", error, [&](const Row& r) { return r.k * normal(r); }},
       {"rectification", "ug/g^2",
        [&](const Row& r) { return find_parameter(estimate, r.prefix + "vibration_rectification")->value; }}});
}

std::vector<Curve> error_curves(const Exposure& exposure, const Data& data) {
  std::vector<Curve> curves;
  for (const Measured& unit : exposure.units) {
    const auto& time = data.series[unit.series].time;
    const bool counted = data.units[unit.unit].pulse > 0.0;
    Curve curve{.name = "pulse_error " + exposure.prefix + name_of(data, unit),
                .figure = "pulse error" + (exposure.prefix.empty() ? "" : ", " + exposure.label),
                .x = {"time", Unit::parse("s")},
                .y = {"pulse error", Unit::parse(counted ? "pulse" : "mg")}};
    const auto add = [&](std::size_t j) { add_point(curve, time[j] - exposure.begin, unit.per_force * unit.error[j]); };
    const std::size_t n = unit.error.size(), stretch = std::max<std::size_t>(1, 2 * n / most_points);
    for (std::size_t begin = 0; begin < n; begin += stretch) {
      std::size_t low = n, high = n;
      for (std::size_t j = begin; j < std::min(n, begin + stretch); ++j) {
        if (!std::isfinite(unit.error[j])) continue;
        if (low == n || unit.error[j] < unit.error[low]) low = j;
        if (high == n || unit.error[j] > unit.error[high]) high = j;
      }
      if (low == n) continue;
      add(std::min(low, high));
      if (low != high) add(std::max(low, high));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

void report_faults(const Exposure& exposure, const Data& data, const Estimate& estimate, Findings& findings) {
  report_motion(exposure, data, findings);
  for (const Measured& unit : exposure.units) {
    const std::string where = place_of(exposure, data, unit);
    report_rest(where, unit, findings);
    report_peaks(where, unit, findings);
    report_clipping(exposure, data, unit, findings);
    report_size(exposure, data, unit, estimate, findings);
  }
}

void report_rests(const std::vector<Exposure>& exposures, const Data& data, Estimate& estimate) {
  const std::size_t units = data.units.size();
  std::vector<double> log_gain(units, std::nan("")), uncertainty(units, 0.0);
  for (const Exposure& exposure : exposures)
    for (const Measured& unit : exposure.units) {
      const Size size = size_of(exposure, data, unit, estimate);
      log_gain[unit.unit] = std::log(size.ratio);
      uncertainty[unit.unit] = size.uncertainty;
    }
  vibration::report_departures(data, log_gain, uncertainty, estimate);
}

}  // namespace tumble::random_vibration
