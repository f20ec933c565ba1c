#include "tumble/methods/random_vibration/measure.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "tumble/methods/random_vibration/screen.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::random_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;
using vibration::Series;

constexpr std::size_t fewest_for_density = 64;    ///< windows of a rest, with which its mean has noise by frequency
constexpr double exact_freedom = 1e6;             ///< of a rest without scatter
constexpr double level_differs_sd = 3.0;          ///< [sd] p = 0.3 %
constexpr std::ptrdiff_t fewest_vibrating = 512;  ///< windows; statistics of fewer are not normal

constexpr double highest_share = 0.02;  ///< of the sampling rate, to which densities are white + blue f^2 + slow/f
constexpr double fading = 0.1;          ///< of the vibration, at either end

double plain_mean(std::span<const double> values) {
  double sum = 0.0, n = 0.0;
  for (const double v : values)
    if (std::isfinite(v)) sum += v, ++n;
  return sum / n;
}

/// docs/equations (3.7)
double standard_deviation(std::span<const double> values) {
  const double mean = plain_mean(values);
  double squares = 0.0, n = 0.0;
  for (const double v : values)
    if (std::isfinite(v)) squares += (v - mean) * (v - mean), ++n;
  return std::sqrt(squares / (n - 1.0));
}

/// The time of each part, and its weight in the difference to the vibration.
std::vector<WeightedSpan> spans_of(const Data& data, const vibration::AtRest& parts, const Series& vibrating) {
  std::vector<WeightedSpan> out{{vibrating.begin, vibrating.end, 1.0}};
  for (const auto& part : parts.parts)
    out.push_back({data.series[part.series].begin, data.series[part.series].end, -part.weight});
  return out;
}

/// The mean of one segment at rest: its variance without slow noise, and the densities behind it.
struct RestMean {
  double variance = 0.0, freedom = 1e6;
  std::optional<DensityAtZero> density;  ///< of long segments
};

RestMean rest_mean(const Series& series, double pulse) {
  RestMean mean;
  if (series.force.size() < fewest_for_density) {
    const vibration::Mean blocks = vibration::mean_of(series, pulse);
    mean.variance = blocks.variance;
    mean.freedom = blocks.degrees_of_freedom;
    return mean;
  }
  const auto n = static_cast<double>(series.force.size());
  mean.density = long_run({series.force}, highest_share, true).density.front();
  const double white = mean.density->white, of_white = mean.density->covariance(0, 0);
  mean.variance = pulses::rounding_variance(pulse, n * series.window) + white / n;
  mean.freedom = of_white > 0.0 ? std::max(1.0, 2.0 * white * white / of_white) : 1.0;
  return mean;
}

Rest rest_of(const Data& data, const Series& vibrating, const vibration::AtRest& parts) {
  Rest rest;
  rest.before = rest.after = std::nan("");
  double squares = 0.0, slow = 0.0, windows = 0.0, white_freedom = 0.0;
  for (const auto& part : parts.parts) {
    const Series& series = data.series[part.series];
    const double mean = plain_mean(series.force);
    (series.middle() < vibrating.middle() ? rest.before : rest.after) = mean;
    rest.value += part.weight * mean;
    const RestMean of_part = rest_mean(series, data.units[vibrating.unit].pulse);
    if (of_part.density) {
      const auto n = static_cast<double>(series.force.size());
      rest.white += n * of_part.density->white;
      slow += n * of_part.density->slow;
      windows += n;
      white_freedom += of_part.freedom;
    }
    const double weighted = part.weight * part.weight * of_part.variance;
    rest.variance += weighted;
    squares += weighted * weighted / of_part.freedom;
  }
  if (windows > 0.0) {
    rest.white /= windows;
    rest.slow_variance = slow / windows * slow_gain(spans_of(data, parts, vibrating));
  }
  rest.white_freedom = std::max(1.0, white_freedom);
  rest.degrees_of_freedom = squares > 0.0 ? std::max(1.0, rest.variance * rest.variance / squares) : exact_freedom;
  rest.both_sides = parts.both_sides;
  if (parts.parts.size() == 2) {
    const Series &first = data.series[parts.parts[0].series], &last = data.series[parts.parts[1].series];
    rest.slope = (rest.after - rest.before) / (last.middle() - first.middle());
  }
  return rest;
}

/// Residual of e = sum of the reference and its neighbours, each times a gain, and the sum of the gains.
void subtract_reference(const std::vector<double>& reference, int lags, Measured& m) {
  Explained result = explained(reference, m.error, lags);
  if (result.residual.empty()) return;
  m.own = std::move(result.residual);
  m.own_sd = standard_deviation(m.own);
  m.reference_gain = result.gain;
}

Measured measured_of(const Data& data, std::size_t index, const std::vector<double>& weights) {
  const Series& series = data.series[index];
  const auto& unit = data.units[series.unit];
  Measured m;
  m.unit = series.unit;
  m.series = index;
  m.per_force = unit.pulse > 0.0 ? series.window / unit.pulse : 1.0;
  m.rest = rest_of(data, series, vibration::at_rest(data, series));
  for (std::size_t j = 0; j < weights.size(); ++j)
    m.error.push_back(series.force[j] - m.rest.value - m.rest.slope * (series.time[j] - series.middle()));
  set_moments(weights, m);
  return m;
}

/// Relative standard uncertainty of the level by the plan: as set, else as the rig says, else unknown.
std::optional<double> level_sd(const Evidence& evidence, std::size_t recording) {
  const Settings& settings = evidence.plan.settings;
  if (settings.has("level_sd")) return settings.number("level_sd");
  return rig_sd(plan_of(evidence, recording), error_names::shake_amplitude);
}

/// g_rms: set, by the plan, or by the reference.
void set_level(const Evidence& evidence, const Data& data, std::size_t recording, Exposure& exposure,
               Findings& findings) {
  const Settings& settings = evidence.plan.settings;
  const double planned = std::sqrt(variance(exposure.psd));
  const bool level_set = settings.has("level");
  exposure.rms = level_set ? settings.number("level") : planned;
  const auto known = level_sd(evidence, recording);
  exposure.rms_sd = exposure.level_sd = known.value_or(0.0);
  const bool wanted = settings.word("level_from") == "reference";
  if (!known && !wanted) findings.push_back({Severity::warning, "level_uncertainty_unknown", {}, exposure.label});
  if (exposure.reference.empty()) {
    if (wanted)
      throw Error(Error::Kind::bad_data, "level_from = \"reference\", and no reference is recorded with the windows");
    return;
  }
  // Instants show all of the vibration, means over the windows show part of it.
  const double expected =
      data.reference_integrated ? std::sqrt(window_variance(exposure.psd, exposure.window)) : planned;
  const double measured = planned * standard_deviation(exposure.reference) / expected;
  const double gain_sd = exposure.gain_sd = settings.number("reference_gain_sd");
  const double difference = measured / exposure.rms - 1.0;
  const double uncertainty =
      std::hypot(exposure.rms_sd, gain_sd, 1.0 / std::sqrt(static_cast<double>(exposure.reference.size())));
  if (std::abs(difference) > level_differs_sd * uncertainty)
    findings.push_back({Severity::warning,
                        "level_differs_from_reference",
                        {{"reference", measured, "g"},
                         {"level", exposure.rms, "g"},
                         {"source", Phrase{level_set ? "level_in_settings" : "level_in_plan"}},
                         {"difference", difference, "%"},
                         {"uncertainty", uncertainty, "%"}},
                        exposure.label});
  if (!wanted) return;
  exposure.rms = measured;
  exposure.rms_sd = gain_sd;
  exposure.from_reference = true;
}

/// Sense of the units' axes along the shake, by the rests of the plan; what moves across.
void set_mounting(const Evidence& evidence, const Data& data, std::size_t recording, Exposure& exposure) {
  const Plan& plan = plan_of(evidence, recording);
  const double elevation = plan.rig.has("shake_elevation") ? plan.rig.number("shake_elevation") : half_pi;
  for (Measured& unit : exposure.units) {
    const double along = data.series[unit.series].rest * std::sin(elevation);
    if (along < -vibration::along_input * standard_gravity) unit.sense = -1.0;
  }
  const std::array directions{error_names::cross_motion_y, error_names::cross_motion_z};
  for (std::size_t k = 0; k < directions.size(); ++k)
    exposure.across[k] = evidence.plan.settings.number("cross_coupling") *
                         rig_sd(plan, directions[k]).value_or(vibration::usual_cross_motion);
}

void report_level(const Data& data, const Exposure& exposure, Findings& findings) {
  const std::vector<FindingValue> values{{"rms", exposure.rms, "g"}, {"uncertainty", exposure.rms_sd, "%"}};
  if (!exposure.from_reference)
    findings.push_back({Severity::info, "level_of_vibration", values, exposure.label});
  else
    findings.push_back({Severity::info,
                        data.reference_integrated ? "level_by_reference_over_windows" : "level_by_reference", values,
                        exposure.label});
}

using Key = std::tuple<std::size_t, std::size_t, std::string>;  ///< recording, power-up, label
using Groups = std::map<Key, std::vector<std::size_t>>;

/// Series of each random vibration. By recording, power-up and label: units with stamps of their own do not begin at
/// one instant. Throws Error::bad_data with everything that is missing.
Groups groups_of(const Data& data) {
  Groups groups;
  Problems problems;
  std::vector<std::string> without;
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    const Series& series = data.series[i];
    if (series.shake.kind != Motion::Kind::random) continue;
    if (vibration::at_rest(data, series).parts.empty()) {
      if (std::ranges::find(without, series.label) == without.end()) without.push_back(series.label);
    } else if (std::ranges::count_if(series.force, [](double v) { return std::isfinite(v); }) < fewest_vibrating) {
      problems.push_back(
          say("{}: fewer than 512 windows, too few for statistics: vibrate for longer", Name{place_of(data, series)}));
    } else {
      groups[{series.recording, series.power_up, series.label}].push_back(i);
    }
  }
  if (!without.empty())
    problems.push_back(
        say("{}: there is no segment at rest in the same power-up and position to subtract: "
            "record the units with the shaker at rest before and after",
            fmt::join(without, ", ")));
  if (groups.empty() && problems.empty()) problems.emplace_back("the schedule has no random vibration");
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  return groups;
}

/// One vibration, without its level.
Exposure exposure_of(const Data& data, const std::vector<std::size_t>& members, int lags) {
  const Series& first = data.series[members.front()];
  Exposure exposure;
  exposure.label = first.label;
  exposure.psd = {first.shake.psd_frequency, first.shake.psd};
  exposure.window = first.window, exposure.interval = first.interval;
  exposure.begin = first.begin, exposure.end = first.end;
  exposure.reference = first.reference;
  std::size_t n = first.force.size();
  for (const std::size_t i : members) n = std::min(n, data.series[i].force.size());
  exposure.weights = faded_weights(n, fading);
  for (const std::size_t i : members) exposure.units.push_back(measured_of(data, i, exposure.weights));
  if (!exposure.reference.empty() && data.reference_integrated)
    for (Measured& unit : exposure.units) subtract_reference(exposure.reference, lags, unit);
  return exposure;
}

}  // namespace

void set_moments(const std::vector<double>& weights, Measured& m) {
  m.lowest = INFINITY, m.highest = -INFINITY;
  m.windows = 0;
  double sum = 0.0, weight = 0.0;
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const double e = m.error[j];
    if (!std::isfinite(e)) continue;
    ++m.windows;
    sum += weights[j] * e;
    weight += weights[j];
    m.lowest = std::min(m.lowest, e);
    m.highest = std::max(m.highest, e);
  }
  m.mean = sum / weight;
  m.plain_mean = plain_mean(m.error);
  m.sd = standard_deviation(m.error);
}

std::vector<double> ranges_of_blocks(const std::vector<double>& error, std::size_t blocks) {
  std::vector<double> out(blocks, 0.0);
  const std::size_t length = error.size() / blocks;
  for (std::size_t b = 0; b < blocks; ++b) {
    double low = INFINITY, high = -INFINITY;
    for (std::size_t j = b * length; j < (b + 1) * length; ++j) {
      if (!std::isfinite(error[j])) continue;
      low = std::min(low, error[j]);
      high = std::max(high, error[j]);
    }
    out[b] = high > low ? high - low : 0.0;
  }
  return out;
}

std::vector<Exposure> exposures_of(const Evidence& evidence, const Data& data, Findings& findings) {
  const Groups groups = groups_of(data);
  std::map<std::string, std::size_t> times, number;
  for (const auto& [key, members] : groups) ++times[std::get<2>(key)];
  std::vector<Exposure> exposures;
  for (const auto& [key, members] : groups) {
    const auto& [recording, power_up, label] = key;
    Exposure exposure = exposure_of(data, members, evidence.plan.settings.integer("reference_lags"));
    // One segment in several power-ups or recordings.
    if (times[label] > 1) exposure.label += fmt::format(" #{}", ++number[label]);
    exposure.prefix = groups.size() > 1 ? exposure.label + "." : "";
    set_mounting(evidence, data, recording, exposure);
    set_level(evidence, data, recording, exposure, findings);
    report_level(data, exposure, findings);
    exposures.push_back(std::move(exposure));
  }
  return exposures;
}

}  // namespace tumble::random_vibration
