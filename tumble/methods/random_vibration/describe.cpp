#include "tumble/methods/random_vibration/describe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::random_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;

constexpr std::size_t most_points = 2000;

double to_g(double force) { return Unit::parse("g").from_si(force); }

std::string name_of(const Data& data, const Measured& unit) { return data.units[unit.unit].name; }

std::string type_of(const Measured& unit, const std::vector<Type>& types) {
  for (const Type& type : types)
    if (std::ranges::find(type.units, unit.unit) != type.units.end()) return type.name;
  return "";
}

/// [m/s^2] of the real motion in the windows: what the reference explains, else what the density says, docs/equations
/// (3.13).
double motion_sd(const Exposure& exposure, const Measured& unit) {
  if (!unit.own.empty()) return std::sqrt(std::max(0.0, unit.sd * unit.sd - unit.own_sd * unit.own_sd));
  return std::sqrt(window_variance(exposure.psd, exposure.window)) * exposure.rms / std::sqrt(variance(exposure.psd));
}

double counting_sd(const Exposure& exposure, const Data& data, const Measured& unit) {
  return std::sqrt(pulses::rounding_variance(data.units[unit.unit].pulse, exposure.window));
}

/// What neither motion nor rounding explains; NaN where only the density is known and hides it.
double own_sd(const Exposure& exposure, const Data& data, const Measured& unit) {
  const double counting = counting_sd(exposure, data, unit);
  if (!unit.own.empty()) return std::sqrt(std::max(0.0, unit.own_sd * unit.own_sd - counting * counting));
  return std::nan("");
}

void say_motion(const Exposure& exposure, const Data& data, Findings& findings) {
  const Measured& unit = exposure.units.front();
  const double share = std::pow(motion_sd(exposure, unit) / unit.sd, 2);
  if (!unit.own.empty()) {
    findings.push_back({Severity::info,
                        fmt::format("{:.4g} % of the variance of {} is motion that the reference shows as well",
                                    100.0 * share, name_of(data, unit)),
                        exposure.label});
    return;
  }
  findings.push_back(
      {Severity::info,
       fmt::format("the commanded density moves the windows by {:.4g} g (standard deviation, after the window's sinc) "
                   "and {} shows {:.4g} g: the standard deviation is of the motion, not of the unit; {} shows the "
                   "unit's own",
                   to_g(motion_sd(exposure, unit)), name_of(data, unit), to_g(unit.sd),
                   exposure.reference.empty()
                       ? "a reference accelerometer recorded as the mean over each window"
                       : "a reference recorded as the mean over each window, and not as instants,"),
       exposure.label});
}

void say_rest(const Exposure& exposure, const Data& data, const Measured& unit, Findings& findings) {
  if (!unit.rest.both_sides)
    findings.push_back({Severity::warning,
                        fmt::format("at rest only {} the vibration: drift, of temperature for example, counts as pulse "
                                    "error; record the units at rest before and after",
                                    std::isnan(unit.rest.before) ? "after" : "before"),
                        name_of(data, unit) + ", " + exposure.label});
  const double change = unit.rest.after - unit.rest.before;
  if (std::abs(change) > 6.0 * std::sqrt(unit.rest.variance + unit.rest.slow_variance) &&
      std::abs(change) > 0.5 * std::abs(unit.mean))
    findings.push_back(
        {Severity::warning,
         fmt::format("at rest {:.3g} mg more after the vibration than before, and the mean shift is {:.3g} "
                     "mg: interpolated as a straight line; let the unit come to its temperature first",
                     1e3 * to_g(change), 1e3 * to_g(unit.mean)),
         name_of(data, unit) + ", " + exposure.label});
}

/// Peaks against those of a normal process.
void say_peaks(const Exposure& exposure, const Data& data, const Measured& unit, Findings& findings) {
  const Extreme extreme = greatest_of(static_cast<double>(unit.windows));
  const double middle = 0.5 * (unit.highest + unit.lowest), half = 0.5 * (unit.highest - unit.lowest);
  const double expected = extreme.mean * unit.sd, sd = extreme.sd * unit.sd / std::numbers::sqrt2;
  const std::string where = name_of(data, unit) + ", " + exposure.label;
  if (half > expected + 5.0 * sd)
    findings.push_back(
        {Severity::warning,
         fmt::format("peak to peak {:.3g} standard deviations, {:.3g} of normal vibration of {} windows: "
                     "knocks, a loose unit or lost pulses; look at the curve pulse_error",
                     2.0 * half / unit.sd, 2.0 * extreme.mean, unit.windows),
         where});
  else if (half < expected - 4.0 * sd)
    findings.push_back(
        {Severity::warning,
         fmt::format("peak to peak {:.3g} standard deviations, {:.3g} of normal vibration of {} windows: "
                     "the shaker's control cuts the peaks, or the unit does",
                     2.0 * half / unit.sd, 2.0 * extreme.mean, unit.windows),
         where});
  if (std::abs(middle) > 6.0 * sd)
    findings.push_back({Severity::warning,
                        fmt::format("the highest error is {:+.3g} and the lowest {:+.3g} standard deviations: not "
                                    "symmetric, as where one side is cut off",
                                    unit.highest / unit.sd, unit.lowest / unit.sd),
                        where});
}

void say_clipping(const Exposure& exposure, const Data& data, const Measured& unit, Findings& findings) {
  if (!data.range) return;
  const Clipping clip = clipping(unit.rest.value, exposure.rms, *data.range);
  const double own = std::sqrt(unit.rest.variance) + 1e-3 * std::abs(unit.mean);
  if (std::abs(clip.shift) < 0.3 * own && clip.share < 1e-5) return;
  findings.push_back(
      {Severity::warning,
       fmt::format("the unit clips: of {:.3g} g rms about {:+.3g} g, {:.2g} % lie beyond its range of {:.3g} g, which "
                   "alone shifts the mean by {:+.3g} mg ({:+.3g} % of the shift found), not symmetric because of a_0; "
                   "vibrate at a lower level or use a unit of wider range: no rectification coefficient follows from "
                   "this run",
                   to_g(exposure.rms), to_g(unit.rest.value), 100.0 * clip.share, to_g(*data.range),
                   1e3 * to_g(clip.shift), 100.0 * clip.shift / unit.mean),
       name_of(data, unit) + ", " + exposure.label});
}

/// The spread against that of the vibration: what the reference shows of it, else what is commanded.
void say_size(const Exposure& exposure, const Data& data, const Measured& unit, const Estimate& estimate,
              Findings& findings) {
  const auto& under_test = data.units[unit.unit];
  const bool by_reference = !unit.own.empty();
  const double expected =
      std::sqrt(window_variance(exposure.psd, exposure.window) * exposure.rms * exposure.rms / variance(exposure.psd) +
                unit.rest.white + std::pow(counting_sd(exposure, data, unit), 2));
  const double ratio = by_reference ? unit.reference_gain : unit.sd / expected;
  const auto* sd = find_parameter(estimate, exposure.prefix + under_test.prefix + "pulse_error_sd");
  const auto index = static_cast<std::size_t>(sd - estimate.parameters.data());
  const double uncertain =
      by_reference ? std::hypot(exposure.gain_sd, under_test.scale_relative_sd)
                   : std::hypot(standard_uncertainty(estimate, index) / sd->value, under_test.scale_relative_sd);
  if (!(std::abs(ratio - 1.0) > std::max(0.03, 4.0 * uncertain))) return;
  findings.push_back(
      {Severity::warning,
       fmt::format("the unit shows {:.4g} times the vibration {} (uncertain by {:.2g} %): it clips (say its range), or "
                   "its scale factor, its mounting, its bandwidth{} is not what it should be; a unit that clips shifts "
                   "its mean by itself",
                   ratio, by_reference ? "that the reference shows" : "that is commanded", 100.0 * uncertain,
                   by_reference ? " or the reference's gain" : " or the level"),
       name_of(data, unit) + ", " + exposure.label});
}

}  // namespace

Table units_table(const std::vector<Exposure>& exposures, const Data& data, const std::vector<Type>& types,
                  const Estimate& estimate) {
  const auto g = Unit::parse("g"), mg = Unit::parse("mg"), one = Unit();
  // Units that count beside units that do not: only a specific force compares.
  const bool counted = std::ranges::all_of(data.units, [](const auto& u) { return u.pulse > 0.0; });
  const Unit error = Unit::parse(counted ? "pulse" : "mg");
  Table table{"units",
              "the units beside each other: pulse error, its part from the motion, from counting, and their own",
              {{"unit", one},
               {"type", one},
               {"vibration", one},
               {"windows", one},
               {"a_0", g},
               {"rest_before", g},
               {"rest_after", g},
               {"plain_mean", error},
               {"mean", error},
               {"mean_sd", error},
               {"sd", error},
               {"sd_from_motion", error},
               {"sd_from_counting", error},
               {"sd_own", error},
               {"peak_to_peak", error},
               {"normal_peak_to_peak", error},
               {"rectification", Unit::parse("ug/g^2")}},
              {}};
  for (const Exposure& exposure : exposures)
    for (const Measured& unit : exposure.units) {
      const std::string prefix = exposure.prefix + data.units[unit.unit].prefix;
      const double k = counted ? unit.per_force : 1.0;
      const auto* mean = find_parameter(estimate, prefix + "pulse_error_mean");
      const auto index = static_cast<std::size_t>(mean - estimate.parameters.data());
      const auto normal = 2.0 * greatest_of(static_cast<double>(unit.windows)).mean * unit.sd;
      table.rows.push_back(
          {name_of(data, unit), type_of(unit, types), exposure.label, static_cast<double>(unit.windows),
           unit.rest.value, unit.rest.before, unit.rest.after, k * unit.plain_mean, k * unit.mean,
           k / unit.per_force * standard_uncertainty(estimate, index), k * unit.sd, k * motion_sd(exposure, unit),
           k * counting_sd(exposure, data, unit), k * own_sd(exposure, data, unit), k * (unit.highest - unit.lowest),
           k * normal, find_parameter(estimate, prefix + "vibration_rectification")->value});
    }
  return table;
}

std::vector<Curve> error_curves(const Exposure& exposure, const Data& data) {
  std::vector<Curve> curves;
  for (const Measured& unit : exposure.units) {
    const auto& time = data.series[unit.series].time;
    const bool counted = data.units[unit.unit].pulse > 0.0;
    Curve curve;
    curve.name = "pulse_error " + exposure.prefix + name_of(data, unit);
    curve.figure = "pulse error" + (exposure.prefix.empty() ? "" : ", " + exposure.label);
    curve.x = {"time", Unit::parse("s"), {}};
    curve.y = {"pulse error", Unit::parse(counted ? "pulse" : "mg"), {}};
    const auto add = [&](std::size_t j) {
      curve.x.values.push_back(time[j] - exposure.begin);
      curve.y.values.push_back(unit.per_force * unit.error[j]);
    };
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

void look_at(const Exposure& exposure, const Data& data, const Estimate& estimate, Findings& findings) {
  say_motion(exposure, data, findings);
  for (const Measured& unit : exposure.units) {
    say_rest(exposure, data, unit, findings);
    say_peaks(exposure, data, unit, findings);
    say_clipping(exposure, data, unit, findings);
    say_size(exposure, data, unit, estimate, findings);
  }
}

}  // namespace tumble::random_vibration
