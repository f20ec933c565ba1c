#include "tumble/methods/random_vibration/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/reduce/pulses/rounding.hpp"

namespace tumble::random_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;

constexpr std::size_t blocks = 64;  ///< of which the ranges are taken

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

/// Density at zero by the noise at rest and the unit's own rectification of a Gaussian vibration.
double expected_white(const Exposure& exposure, const Measured& unit) {
  const double rectification = unit.mean / (exposure.rms * exposure.rms);
  return unit.rest.white + rectification * rectification * density_of_square(exposure.psd) / exposure.interval;
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

/// Noise at rest of the ratio of two means: the rectification of the common vibration cancels.
double white_of_ratio(const Exposure& exposure, const std::vector<std::size_t>& over,
                      const std::vector<std::size_t>& under, double ratio, double mean_under) {
  const auto mean_white = [&](const std::vector<std::size_t>& members) {
    double white = 0.0;
    for (const std::size_t m : members) white += exposure.units[m].rest.white;
    return white / static_cast<double>(members.size() * members.size());
  };
  return (mean_white(over) + ratio * ratio * mean_white(under)) / (mean_under * mean_under);
}

/// Members of a type in this vibration: indices of Exposure::units.
std::vector<std::size_t> members_of(const Exposure& exposure, const Type& type) {
  std::vector<std::size_t> out;
  for (std::size_t m = 0; m < exposure.units.size(); ++m)
    if (std::ranges::find(type.units, exposure.units[m].unit) != type.units.end()) out.push_back(m);
  return out;
}

/// Whether the mean can be a divisor: it is at least four standard uncertainties from zero.
bool can_divide(const Exposure& exposure, const Statistic& mean, const std::vector<std::size_t>& members) {
  double variance = 0.0;
  for (const std::size_t m : members) {
    const Measured& unit = exposure.units[m];
    const double share = 1.0 / static_cast<double>(members.size());
    variance += share * share *
                (unit.rest.variance + unit.rest.slow_variance +
                 expected_white(exposure, unit) / static_cast<double>(unit.windows));
  }
  return std::abs(mean.parameter.value) > 4.0 * std::sqrt(variance);
}

/// The first type over each of the others, in specific force.
void append_ratios(const Exposure& exposure, const std::vector<Type>& types, std::vector<Statistic>& out,
                   Findings& findings) {
  std::vector<Triple> of_type;
  std::vector<std::vector<std::size_t>> members;
  std::vector<std::string> names;
  for (const Type& type : types) {
    const auto here = members_of(exposure, type);
    if (here.empty()) continue;
    std::vector<Triple> parts;
    for (const std::size_t m : here) parts.push_back(triple_of(exposure, exposure.units[m]));
    of_type.push_back(mean_over(parts));
    members.push_back(here);
    names.push_back(type.name);
  }
  for (std::size_t k = 1; k < of_type.size(); ++k) {
    const std::string prefix = exposure.prefix + names[0] + "_over_" + names[k] + ".";
    const std::string what = fmt::format(" of {} over {}, in g, the vibration in common", names[0], names[k]);
    if (can_divide(exposure, of_type[k].mean, members[k])) {
      Statistic mean = ratio_of(of_type[0].mean, of_type[k].mean);
      mean.expected_white =
          white_of_ratio(exposure, members[0], members[k], mean.parameter.value, of_type[k].mean.parameter.value);
      mean.expected_freedom = std::min(of_type[0].mean.expected_freedom, of_type[k].mean.expected_freedom);
      name(mean, prefix + "mean_ratio", "r_mean", "1", "means of the pulse error" + what);
      out.push_back(std::move(mean));
    } else {
      findings.push_back({Severity::info,
                          "no_mean_ratio",
                          {{"parameter", prefix + "mean_ratio"}, {"type", names[k]}},
                          exposure.label});
    }
    Statistic sd = ratio_of(of_type[0].sd, of_type[k].sd), range = ratio_of(of_type[0].range, of_type[k].range);
    name(sd, prefix + "sd_ratio", "r_s", "1", "standard deviations of the pulse error" + what);
    name(range, prefix + "peak_to_peak_ratio", "r_pp", "1", "peak to peak of the pulse error" + what);
    out.insert(out.end(), {sd, range});
  }
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
