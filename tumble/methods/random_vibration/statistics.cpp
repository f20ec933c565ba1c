#include "tumble/methods/random_vibration/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::random_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;

constexpr double shift_shown_sd = 4.0;  ///< [sd] p = 6e-5

constexpr std::size_t blocks = 64;           ///< of which the ranges are taken
constexpr std::size_t fewest_windows = 512;  ///< that units have in common

/// Statistics of one unit, or of the mean of several, before they are given a name. [m/s^2]
struct Triple {
  Statistic mean, sd, range;
};

std::vector<double> squares_of(const std::vector<double>& values, double mean, double factor) {
  std::vector<double> out;
  out.reserve(values.size());
  for (const double v : values) out.push_back(factor * (v - mean) * (v - mean));
  return out;
}

/// Density at zero that missing windows make of the motion: each gap of L windows takes the mean over L H from the sum.
double white_of_gaps(const Exposure& exposure, const Measured& unit) {
  const double level = exposure.rms * exposure.rms / variance(exposure.psd);
  std::map<std::size_t, double> of_length;
  double sum = 0.0;
  for (std::size_t j = 0, length = 0; j <= exposure.weights.size(); ++j) {
    if (j < exposure.weights.size() && !std::isfinite(unit.error[j])) {
      ++length;
      continue;
    }
    if (length > 0) {
      const auto windows = static_cast<double>(length);
      const auto [part, is_new] = of_length.emplace(length, 0.0);
      if (is_new) part->second = windows * windows * level * window_variance(exposure.psd, windows * exposure.window);
      sum += part->second;
    }
    length = 0;
  }
  return sum / static_cast<double>(exposure.weights.size());
}

/// Density at zero by the noise at rest and the unit's own rectification of a Gaussian vibration, and by gaps.
double expected_white(const Exposure& exposure, const Measured& unit) {
  const double rectification = unit.mean / (exposure.rms * exposure.rms);
  return unit.rest.white + rectification * rectification * density_of_square(exposure.psd) / exposure.interval +
         white_of_gaps(exposure, unit);
}

Triple triple_of(const Exposure& exposure, const Measured& unit) {
  Triple t;
  t.mean.parameter.value = unit.mean;
  t.mean.influence = unit.error;
  t.mean.faded = true;
  t.mean.expected_white = expected_white(exposure, unit);
  t.mean.expected_freedom = unit.rest.white_freedom;
  t.mean.rest[unit.unit] = -1.0;
  t.mean.level = 2.0 * unit.mean;
  t.sd.parameter.value = unit.sd;
  t.sd.influence = squares_of(unit.error, unit.plain_mean, 0.5 / unit.sd);
  t.sd.level = unit.sd;
  t.range.parameter.value = unit.highest - unit.lowest;
  t.range.ranges = ranges_of_blocks(unit.error, blocks);
  const auto n = static_cast<double>(unit.windows);
  t.range.shrinking = greatest_of(n).sd / greatest_of(n / static_cast<double>(blocks)).sd;
  t.range.level = t.range.parameter.value;
  for (Statistic* s : {&t.mean, &t.sd, &t.range}) s->scale[unit.unit] = -s->parameter.value;
  return t;
}

void add_scaled(std::vector<double>& sum, const std::vector<double>& values, double factor) {
  if (sum.empty()) sum.assign(values.size(), 0.0);
  for (std::size_t j = 0; j < sum.size(); ++j) sum[j] += factor * values[j];
}

/// Adds the influences and derivatives of `part`, times a factor; value and expected density do not change.
void add_scaled(Statistic& sum, const Statistic& part, double factor) {
  if (!part.influence.empty()) add_scaled(sum.influence, part.influence, factor);
  if (!part.ranges.empty()) add_scaled(sum.ranges, part.ranges, factor);
  sum.faded = part.faded;
  sum.shrinking = part.shrinking;
  sum.level += factor * part.level;
  for (const auto& [unit, slope] : part.rest) sum.rest[unit] += factor * slope;
  for (const auto& [unit, slope] : part.scale) sum.scale[unit] += factor * slope;
}

Statistic times(const Statistic& s, double factor) {
  Statistic out = s;
  out.parameter.value *= factor;
  for (double& v : out.influence) v *= factor;
  for (double& v : out.ranges) v *= factor;
  out.level *= factor;
  out.gain *= factor;
  if (out.expected_white >= 0.0) out.expected_white *= factor * factor;
  for (auto& [unit, slope] : out.rest) slope *= factor;
  for (auto& [unit, slope] : out.scale) slope *= factor;
  return out;
}

void name(Statistic& s, std::string name, const char* symbol, const char* unit, std::string description) {
  s.parameter.name = std::move(name);
  s.parameter.symbol = symbol;
  s.parameter.unit = Unit::parse(unit);
  s.parameter.description = std::move(description);
}

/// dMean/g_rms^2 = K_2 + 3 K_3 a_0, docs/equations (3.12).
Statistic rectification_of(const Exposure& exposure, const Statistic& mean) {
  const double square = exposure.rms * exposure.rms;
  Statistic s = times(mean, 1.0 / square);
  if (exposure.from_reference) {
    // The level is the reference's: an error of the shaker cancels, and the sampling error of the reference's variance
    // is in the ratio.
    s.gain = s.level;
    s.level = 0.0;
    const double variance = [&] {
      double sum = 0.0, there = 0.0;
      for (const double r : exposure.reference)
        if (std::isfinite(r)) sum += r * r, ++there;
      return sum / there;
    }();
    for (std::size_t j = 0; j < s.influence.size(); ++j)
      s.influence[j] -= s.parameter.value * exposure.reference[j] * exposure.reference[j] / variance;
    s.expected_white = -1.0;
  }
  return s;
}

/// Statistics of one unit over the vibration, in its pulses.
void append_unit(const Exposure& exposure, const Data& data, const Measured& unit, std::vector<Statistic>& out) {
  const auto& under_test = data.units[unit.unit];
  const std::string prefix = exposure.prefix + under_test.prefix;
  const std::size_t before = out.size();
  const char* shown = under_test.pulse > 0.0 ? "pulse" : "mg";
  const Triple t = triple_of(exposure, unit);
  Statistic mean = times(t.mean, unit.per_force), sd = times(t.sd, unit.per_force),
            range = times(t.range, unit.per_force);
  for (Statistic* s : {&mean, &sd, &range})
    if (under_test.pulse > 0.0) s->scale.clear();  // pulses are what was counted
  name(mean, prefix + "pulse_error_mean", "mean e", shown, "mean of the windows in vibration less that at rest");
  name(sd, prefix + "pulse_error_sd", "s", shown, "standard deviation of the windows, (3.7)");
  name(range, prefix + "pulse_error_peak_to_peak", "e_pp", shown,
       fmt::format("highest less lowest of {} windows; grows with their number", unit.windows));
  out.insert(out.end(), {mean, sd, range});
  if (!unit.own.empty()) {
    Statistic own;
    own.parameter.value = unit.own_sd;
    own.influence = squares_of(unit.own, 0.0, 0.5 / unit.own_sd);
    const double rounding = pulses::rounding_variance(under_test.pulse, exposure.window);
    own.level = std::max(0.0, unit.own_sd - rounding / unit.own_sd);  // rounding does not grow with the vibration
    own.scale[unit.unit] = -unit.own_sd;
    own = times(own, unit.per_force);
    if (under_test.pulse > 0.0) own.scale.clear();
    name(own, prefix + "pulse_error_sd_own", "s_own", shown,
         "standard deviation after subtracting the reference: the unit and its counter");
    out.push_back(std::move(own));
  }
  Statistic rectification = rectification_of(exposure, t.mean);
  const double a_0 = Unit::parse("g").from_si(unit.rest.value);
  name(rectification, prefix + "vibration_rectification", "VRC", "ug/g^2",
       fmt::format("K_2 + 3 K_3 a_0 with a_0 = {:+.3f} g", a_0));
  out.push_back(std::move(rectification));
  for (std::size_t i = before; i < out.size(); ++i) out[i].parameter.channels = {under_test.name};
}

/// The mean of the units' statistics.
Triple mean_over(const std::vector<Triple>& parts) {
  Triple sum;
  const double share = 1.0 / static_cast<double>(parts.size());
  double white = 0.0, freedom = INFINITY;
  for (const Triple& part : parts) {
    add_scaled(sum.mean, part.mean, share);
    add_scaled(sum.sd, part.sd, share);
    add_scaled(sum.range, part.range, share);
    sum.mean.parameter.value += share * part.mean.parameter.value;
    sum.sd.parameter.value += share * part.sd.parameter.value;
    sum.range.parameter.value += share * part.range.parameter.value;
    white += share * share * part.mean.expected_white;
    freedom = std::min(freedom, part.mean.expected_freedom);
  }
  sum.mean.expected_white = white, sum.mean.expected_freedom = freedom;
  return sum;
}

Statistic ratio_of(const Statistic& over, const Statistic& under) {
  const double value = over.parameter.value / under.parameter.value;
  Statistic out;
  add_scaled(out, over, 1.0 / under.parameter.value);
  add_scaled(out, under, -value / under.parameter.value);
  out.parameter.value = value;
  out.shrinking = 1.0;  // the difference of two units at one peak does not depend on how rare the peak is
  return out;
}

using Units = std::vector<Measured>;

/// Noise at rest of the ratio of two means: the rectification of the common vibration cancels. Of the motion in missing
/// windows 1 less the ratio remains.
double white_of_ratio(const Exposure& exposure, const Units& over, const Units& under, double ratio,
                      double mean_under) {
  const auto mean_white = [](const Units& units) {
    double white = 0.0;
    for (const Measured& unit : units) white += unit.rest.white;
    return white / static_cast<double>(units.size() * units.size());
  };
  const double motion = (1.0 - ratio) * (1.0 - ratio) * white_of_gaps(exposure, under.front());
  return (mean_white(over) + ratio * ratio * mean_white(under) + motion) / (mean_under * mean_under);
}

/// Members of a type in this vibration.
Units members_of(const Exposure& exposure, const Type& type) {
  Units out;
  for (const Measured& unit : exposure.units)
    if (std::ranges::find(type.units, unit.unit) != type.units.end()) out.push_back(unit);
  return out;
}

/// Keeps the windows that all of these units have: only in these the common motion cancels. Returned: their number.
std::size_t keep_common(const Exposure& exposure, Units& a, Units& b) {
  std::size_t common = 0;
  for (std::size_t j = 0; j < exposure.weights.size(); ++j) {
    const auto missing = [&](const Measured& unit) { return !std::isfinite(unit.error[j]); };
    if (std::ranges::none_of(a, missing) && std::ranges::none_of(b, missing)) {
      ++common;
      continue;
    }
    for (Units* units : {&a, &b})
      for (Measured& unit : *units) unit.error[j] = std::nan("");
  }
  for (Units* units : {&a, &b})
    for (Measured& unit : *units) set_moments(exposure.weights, unit);
  return common;
}

Triple mean_of(const Exposure& exposure, const Units& units) {
  std::vector<Triple> parts;
  for (const Measured& unit : units) parts.push_back(triple_of(exposure, unit));
  return mean_over(parts);
}

/// Whether the mean can be a divisor: it is at least four standard uncertainties from zero.
bool can_divide(const Exposure& exposure, const Statistic& mean, const Units& units) {
  double variance = 0.0;
  for (const Measured& unit : units) {
    const double share = 1.0 / static_cast<double>(units.size());
    variance += share * share *
                (unit.rest.variance + unit.rest.slow_variance +
                 expected_white(exposure, unit) / static_cast<double>(unit.windows));
  }
  return std::abs(mean.parameter.value) > shift_shown_sd * std::sqrt(variance);
}

/// One type over another, in specific force.
void append_ratio(const Exposure& exposure, const Type& first, const Type& other, std::vector<Statistic>& out,
                  Findings& findings) {
  Units over = members_of(exposure, first), under = members_of(exposure, other);
  if (over.empty() || under.empty()) return;
  const std::string prefix = exposure.prefix + first.name + "_over_" + other.name + ".";
  if (keep_common(exposure, over, under) < fewest_windows) {
    findings.push_back({Severity::warning,
                        "no_common_windows",
                        {{"parameter", prefix + "sd_ratio"}, {"needed", fewest_windows}},
                        exposure.label});
    return;
  }
  const Triple a = mean_of(exposure, over), b = mean_of(exposure, under);
  const std::string what = fmt::format(" of {} over {}, in g, the vibration in common", first.name, other.name);
  if (can_divide(exposure, b.mean, under)) {
    Statistic mean = ratio_of(a.mean, b.mean);
    mean.expected_white = white_of_ratio(exposure, over, under, mean.parameter.value, b.mean.parameter.value);
    mean.expected_freedom = std::min(a.mean.expected_freedom, b.mean.expected_freedom);
    name(mean, prefix + "mean_ratio", "r_mean", "1", "means of the pulse error" + what);
    out.push_back(std::move(mean));
  } else {
    findings.push_back({Severity::info,
                        "no_mean_ratio",
                        {{"parameter", prefix + "mean_ratio"}, {"type", other.name}},
                        exposure.label});
  }
  Statistic sd = ratio_of(a.sd, b.sd), range = ratio_of(a.range, b.range);
  name(sd, prefix + "sd_ratio", "r_s", "1", "standard deviations of the pulse error" + what);
  name(range, prefix + "peak_to_peak_ratio", "r_pp", "1", "peak to peak of the pulse error" + what);
  out.insert(out.end(), {sd, range});
}

/// The first type over each of the others.
void append_ratios(const Exposure& exposure, const std::vector<Type>& types, std::vector<Statistic>& out,
                   Findings& findings) {
  const auto has_units = [&](const Type& type) { return !members_of(exposure, type).empty(); };
  const auto first = std::ranges::find_if(types, has_units);
  if (first == types.end()) return;
  for (auto other = first + 1; other != types.end(); ++other) append_ratio(exposure, *first, *other, out, findings);
}

}  // namespace

std::vector<Statistic> statistics_of(const Exposure& exposure, const Data& data, const std::vector<Type>& types,
                                     Findings& findings) {
  std::vector<Statistic> out;
  for (const Measured& unit : exposure.units) append_unit(exposure, data, unit, out);
  append_ratios(exposure, types, out, findings);
  return out;
}

}  // namespace tumble::random_vibration
