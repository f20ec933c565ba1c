#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/math/normal.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/vibration/faults.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::vibration {
namespace {

using Severity = Finding::Severity;

constexpr double departs_sd = 4.0;  ///< [sd] of rest and plan: p = 6e-5
/// A cause explains a departure within [sd], and leaves at most [1] of what the other leaves.
constexpr double explains_sd = 4.0, explains_of_other = 0.5, gain_of_fixture = 0.01;
constexpr std::size_t fewest_residuals = 32;
constexpr double outlier_sd = 6.0;  ///< p = 2e-9

/// Specific force [1 of gravity] that an input axis 2 deg off its direction adds where it should lie along gravity, and
/// where it should be level.
constexpr double along_by_tilt = 6e-4, across_by_tilt = 0.035;

/// Segments at rest of one unit: planned and shown [m/s^2].
struct Rests {
  std::vector<double> planned, shown, variance;
};

Rests rests_of(const Data& data, std::size_t unit) {
  Rests rests;
  for (const Series& series : data.series) {
    if (series.unit != unit || !series.at_rest() || !std::isfinite(series.rest)) continue;
    const Mean mean = mean_of(series, data.units[unit].pulse);
    rests.planned.push_back(series.rest);
    rests.shown.push_back(mean.value);
    rests.variance.push_back(mean.variance);
  }
  return rests;
}

/// The axis both ways: half of the difference of the outermost, which has no bias.
RestDeparture both_ways(const Rests& rests, std::size_t low, std::size_t high) {
  RestDeparture d;
  d.shown = 0.5 * (rests.shown[high] - rests.shown[low]);
  d.planned = 0.5 * (rests.planned[high] - rests.planned[low]);
  d.uncertainty = 0.5 * std::sqrt(rests.variance[high] + rests.variance[low]);
  d.without_bias = true;
  return d;
}

RestDeparture one_way(const Rests& rests, std::size_t high, double bias_sd) {
  RestDeparture d;
  d.shown = rests.shown[high];
  d.planned = rests.planned[high];
  d.uncertainty = std::hypot(std::sqrt(rests.variance[high]), bias_sd);
  return d;
}

std::optional<RestDeparture> departure_of(const Rests& rests, double bias_sd, double scale_sd) {
  if (rests.planned.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax_element(rests.planned);
  const auto low = static_cast<std::size_t>(lowest - rests.planned.begin()),
             high = static_cast<std::size_t>(highest - rests.planned.begin());
  const auto steepest = std::abs(*lowest) > std::abs(*highest) ? low : high;
  RestDeparture d =
      *highest - *lowest > standard_gravity ? both_ways(rests, low, high) : one_way(rests, steepest, bias_sd);
  const bool level = std::abs(d.planned) < along_input * standard_gravity;
  const double tilt = (level ? across_by_tilt : along_by_tilt) * standard_gravity;
  d.uncertainty = std::hypot(d.uncertainty, scale_sd * d.planned, tilt);
  if (std::abs(d.shown - d.planned) <= departs_sd * d.uncertainty) return {};
  return d;
}

/// Indices of the parameters that rest on the scale factor of a unit: those of its channel, except pulses, which are
/// counted.
std::vector<std::size_t> resting_on(const UnitUnderTest& unit, const Estimate& estimate) {
  const Dimension pulses = Unit::parse("pulse").dimension();
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const Parameter& p = estimate.parameters[i];
    const bool counted = unit.pulse > 0.0 && p.unit.dimension() == pulses;
    const bool own = p.channels.empty() || std::ranges::find(p.channels, unit.name) != p.channels.end();
    if (own && !counted) indices.push_back(i);
  }
  return indices;
}

std::string names_of(const std::vector<std::size_t>& indices, const Estimate& estimate) {
  std::string text;
  for (const std::size_t i : indices) text += (text.empty() ? "" : " ") + estimate.parameters[i].name;
  return text;
}

/// What makes rest and plan differ.
enum class Cause { sign, scale, bias, unknown };

Cause cause_of(const RestDeparture& d, double log_gain, double uncertainty) {
  if (std::abs(d.planned) < along_input * standard_gravity) return Cause::unknown;
  const double ratio = d.ratio();
  if (ratio < -0.5) return Cause::sign;
  if (d.without_bias) return Cause::scale;
  if (!(ratio > 0.0) || !std::isfinite(log_gain)) return Cause::unknown;
  // Loops and fixtures raise or lower a gain by some parts in a hundred even at the lowest tone.
  const double sd = std::hypot(uncertainty, gain_of_fixture), by_scale = std::abs(log_gain - std::log(ratio)) / sd,
               by_bias = std::abs(log_gain) / sd;
  if (by_scale < explains_sd && by_scale < explains_of_other * by_bias) return Cause::scale;
  if (by_bias < explains_sd && by_bias < explains_of_other * by_scale) return Cause::bias;
  return Cause::unknown;
}

/// Whether a unit whose scale factor is from its rests counts down where another one on the fixture counts up.
bool is_turned_over(const Data& data, std::size_t unit) {
  const auto up = [](const UnitUnderTest& other) { return other.force_per_value > 0.0; };
  return data.units[unit].force_per_value < 0.0 && std::ranges::any_of(data.units, up);
}

/// Its rests as they are with the scale factor's size alone.
RestDeparture turned_over(const Data& data, std::size_t unit) {
  RestDeparture d{.unit = unit};
  for (const Series& series : data.series)
    if (series.unit == unit && series.at_rest() && std::abs(series.rest) > std::abs(d.planned)) d.planned = series.rest;
  d.shown = -d.planned;
  d.uncertainty = data.units[unit].scale_relative_sd * std::abs(d.planned);
  return d;
}

/// [1] Standard uncertainty of the logarithm of what a rest shows over what is planned.
double log_sd(const RestDeparture& d) { return d.uncertainty / std::abs(d.planned); }

/// Whether the rest is the planned one if the values of the unit are those of the other.
bool fits_scale_of(const Data& data, const RestDeparture& d, std::size_t other) {
  const double ratio = data.units[d.unit].force_per_value / data.units[other].force_per_value;
  return d.ratio() > 0.0 && ratio > 0.0 && std::abs(std::log(d.ratio() / ratio)) < departs_sd * log_sd(d);
}

/// Errors for pairs of units whose rests are as planned with the scale factor of each other.
void report_exchanged(const Data& data, Findings& findings) {
  const auto& all = data.departures;
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const bool given = !data.units[all[a].unit].scale_from_rest && !data.units[all[b].unit].scale_from_rest;
      if (!given || !fits_scale_of(data, all[a], all[b].unit) || !fits_scale_of(data, all[b], all[a].unit)) continue;
      findings.push_back({Severity::error,
                          "units_exchanged",
                          {{"first_unit", data.units[all[b].unit].name},
                           {"second_unit", data.units[all[a].unit].name},
                           {"first_ratio", all[b].ratio()},
                           {"second_ratio", all[a].ratio()}}});
    }
}

}  // namespace

void compare_rests(const Settings& settings, Data& data) {
  for (std::size_t unit = 0; unit < data.units.size(); ++unit) {
    if (data.units[unit].scale_from_rest) {
      if (is_turned_over(data, unit)) data.departures.push_back(turned_over(data, unit));
      continue;
    }
    auto departure = departure_of(rests_of(data, unit), settings.number("bias_sd"), data.units[unit].scale_relative_sd);
    if (!departure) continue;
    departure->unit = unit;
    data.departures.push_back(*departure);
  }
}

void report_departures(const Data& data, const std::vector<double>& log_gain, const std::vector<double>& uncertainty,
                       Estimate& estimate) {
  for (const RestDeparture& d : data.departures) {
    const std::string where = data.units[d.unit].prefix.empty() ? "" : data.units[d.unit].name;
    const double off = (d.shown - d.planned) / d.planned;
    const auto about = resting_on(data.units[d.unit], estimate);
    const std::vector<FindingValue> values{{"shown", d.shown, "g"},
                                           {"planned", d.planned, "g"},
                                           {"difference", off, "%"},
                                           {"ratio", std::abs(d.shown - d.planned) / d.uncertainty},
                                           {"parameters", names_of(about, estimate)}};
    const Cause cause = cause_of(d, log_gain[d.unit], uncertainty[d.unit]);
    auto& findings = estimate.findings;
    if (cause == Cause::sign)
      findings.push_back({Severity::error, "rest_inverted", values, where});
    else if (cause == Cause::scale)
      findings.push_back({Severity::error, "scale_factor_differs_at_rest", values, where});
    else if (cause == Cause::bias)
      findings.push_back({Severity::info, "bias_beyond_stated", values, where});
    else
      findings.push_back({Severity::warning, "rest_differs_from_plan", values, where});
    findings.back().about = about;
  }
  report_exchanged(data, estimate.findings);
}

void refuse_sizes(const Data& data, Problems& problems) {
  constexpr double least = 1e-12, most = 1e12;  // [m/s^2]
  const auto check = [&](const std::string& name, double size) {
    if (size == 0.0 || (size > least && size < most)) return;
    problems.push_back(
        say("'{}' shows {:.3g} m/s^2 at most, which no accelerometer does: check its unit and its scale factor", name,
            size));
  };
  double reference = 0.0;
  for (std::size_t unit = 0; unit < data.units.size(); ++unit) {
    double size = 0.0;
    for (const Series& series : data.series) {
      if (series.unit != unit) continue;
      for (const double v : series.force)
        if (!std::isnan(v)) size = std::max(size, std::abs(v));
      for (const double v : series.reference)
        if (!std::isnan(v)) reference = std::max(reference, std::abs(v));
    }
    check(data.units[unit].channel, size);
  }
  check("reference", reference);
}

double rounding_sd(const Series& series, double pulse) {
  if (pulse > 0.0) return std::sqrt(pulses::rounding_variance(pulse, series.window));
  double least = INFINITY;
  for (std::size_t i = 1; i < series.force.size(); ++i)
    if (const double step = std::abs(series.force[i] - series.force[i - 1]); step > 0.0) least = std::min(least, step);
  return std::isfinite(least) ? least / std::sqrt(6.0) : 0.0;
}

Outliers outliers_of(const std::vector<double>& residual, double least) {
  std::vector<double> sizes;
  for (const double r : residual)
    if (!std::isnan(r)) sizes.push_back(std::abs(r));
  Outliers outliers;
  if (sizes.size() < fewest_residuals) return outliers;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  const double limit = outlier_sd * std::max(sd_of_median_size * *middle, least);
  for (std::size_t i = 0; i < residual.size(); ++i) {
    if (!(std::abs(residual[i]) > limit)) continue;
    outliers.index.push_back(i);
    outliers.sum += residual[i];
  }
  return windows_of_outlier * outliers.index.size() > sizes.size() ? Outliers{} : outliers;
}

void add_outliers(const Data& data, const Series& series, const Outliers& outliers, Findings& findings) {
  if (outliers.index.empty()) return;
  const UnitUnderTest& unit = data.units[series.unit];
  const char* code = unit.pulse > 0.0 ? "windows_off_by_pulses" : "windows_off";
  const std::string where = unit.prefix.empty() ? "" : unit.name;
  const double shift = outliers.sum / static_cast<double>(series.force.size());
  const double pulses = unit.pulse > 0.0 ? outliers.sum * series.window / unit.pulse : 0.0;
  const Place place(series.label, series.time[outliers.index.front()]);
  for (Finding& earlier : findings) {
    if (earlier.code != code || earlier.where != where) continue;
    auto values = earlier.values;
    const double before = std::get<double>(values[0].value), most = std::get<double>(values[1].value);
    values[0].value = before + pulses;
    const bool worse = std::abs(shift) > std::abs(most);
    if (worse) values[1].value = shift;
    const Occurrences& often = earlier.occurrences;
    earlier = Finding(Severity::warning, code, values, where,
                      {often.count + outliers.index.size(), often.first, worse ? place : often.worst});
    return;
  }
  findings.push_back({Severity::warning,
                      code,
                      {{"pulses", pulses, "pulse"}, {"shift", shift, "mg"}},
                      where,
                      {outliers.index.size(), place, place}});
}

}  // namespace tumble::vibration
