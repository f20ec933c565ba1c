#include "tumble/methods/random_vibration/measure.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "tumble/core/say.hpp"
#include "tumble/math/eigen/dense.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/units/error.hpp"

namespace tumble::random_vibration {
namespace {

using Severity = Finding::Severity;
using vibration::Data;
using vibration::Series;

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

/// The time each part stands for, and with which weight it goes into the difference to the vibration.
std::vector<WeightedSpan> spans_of(const Data& data, const vibration::AtRest& parts, const Series& vibrating) {
  std::vector<WeightedSpan> out{{vibrating.begin, vibrating.end, 1.0}};
  for (const auto& part : parts.parts)
    out.push_back({data.series[part.series].begin, data.series[part.series].end, -part.weight});
  return out;
}

Rest rest_of(const Data& data, const Series& vibrating, const vibration::AtRest& parts) {
  Rest rest;
  rest.before = rest.after = std::nan("");
  const double pulse = data.units[vibrating.unit].pulse;
  double squares = 0.0, slow = 0.0, slow_windows = 0.0, white_windows = 0.0, white_freedom = 0.0;
  for (const auto& part : parts.parts) {
    const Series& series = data.series[part.series];
    const double mean = plain_mean(series.force);
    (series.middle() < vibrating.middle() ? rest.before : rest.after) = mean;
    rest.value += part.weight * mean;
    const auto n = static_cast<double>(series.force.size());
    double variance = pulses::rounding_variance(pulse, n * series.window), freedom = 1e6;
    if (series.force.size() >= 64) {
      const auto run = long_run({series.force}, highest_share, true);
      const auto& density = run.density.front();
      const double white = density.white, of_white = density.covariance(0, 0);
      variance += white / n;
      freedom = of_white > 0.0 ? std::max(1.0, 2.0 * white * white / of_white) : 1.0;
      rest.white += n * white;
      white_windows += n;
      white_freedom += freedom;
      slow += n * density.slow;
      slow_windows += n;
    } else {
      const vibration::Mean blocks = vibration::mean_of(series, pulse);
      variance = blocks.variance;
      freedom = blocks.degrees_of_freedom;
    }
    const double weighted = part.weight * part.weight * variance;
    rest.variance += weighted;
    squares += weighted * weighted / freedom;
  }
  if (white_windows > 0.0) rest.white /= white_windows;
  rest.white_freedom = std::max(1.0, white_freedom);
  if (slow_windows > 0.0) rest.slow_variance = slow / slow_windows * slow_gain(spans_of(data, parts, vibrating));
  rest.degrees_of_freedom = squares > 0.0 ? std::max(1.0, rest.variance * rest.variance / squares) : 1e6;
  rest.both_sides = parts.both_sides;
  if (parts.parts.size() == 2) {
    const Series &first = data.series[parts.parts[0].series], &last = data.series[parts.parts[1].series];
    rest.slope = (rest.after - rest.before) / (last.middle() - first.middle());
  }
  return rest;
}

/// e = sum of the reference and its neighbours, each times a gain: what is left, and the sum of the gains.
void take_off_reference(const std::vector<double>& reference, int lags, Measured& m) {
  const auto n = static_cast<Eigen::Index>(std::min(m.error.size(), reference.size()));
  const Eigen::Index width = 2 * lags + 2;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(width, width);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(width), row(width);
  const auto fill = [&](Eigen::Index j) {
    row[0] = 1.0;
    for (Eigen::Index k = 1; k < width; ++k) row[k] = reference[static_cast<std::size_t>(j + k - 1 - lags)];
    return row.allFinite() && std::isfinite(m.error[static_cast<std::size_t>(j)]);
  };
  for (Eigen::Index j = lags; j < n - lags; ++j) {
    if (!fill(j)) continue;
    normal += row * row.transpose();
    right += row * m.error[static_cast<std::size_t>(j)];
  }
  const Eigen::VectorXd gains = normal.ldlt().solve(right);
  if (!gains.allFinite()) return;
  m.own.assign(m.error.size(), std::nan(""));
  for (Eigen::Index j = lags; j < n - lags; ++j)
    if (fill(j)) m.own[static_cast<std::size_t>(j)] = m.error[static_cast<std::size_t>(j)] - gains.dot(row);
  m.own_sd = standard_deviation(m.own);
  m.reference_gain = gains.tail(width - 1).sum();
}

Measured measured_of(const Data& data, std::size_t index, const std::vector<double>& weights) {
  const Series& series = data.series[index];
  const auto& unit = data.units[series.unit];
  Measured m;
  m.unit = series.unit;
  m.series = index;
  m.per_force = unit.pulse > 0.0 ? series.window / unit.pulse : 1.0;
  m.rest = rest_of(data, series, vibration::at_rest(data, series));
  m.lowest = INFINITY, m.highest = -INFINITY;
  double sum = 0.0, weight = 0.0;
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const double e = series.force[j] - m.rest.value - m.rest.slope * (series.time[j] - series.middle());
    m.error.push_back(e);
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
  return m;
}

/// Relative standard uncertainty of the level by the plan: as set, else as the rig says, else unknown.
std::optional<double> level_sd(const Evidence& evidence, std::size_t recording) {
  const Settings& settings = evidence.plan.settings;
  if (settings.has("level_sd")) return settings.number("level_sd");
  return rig_sd(plan_of(evidence, recording), rigs::error_names::shake_amplitude);
}

void say_unknown_level(const Exposure& exposure, Findings& findings) {
  findings.push_back(
      {Severity::warning,
       "nothing says how well the level of the vibration is known, so that its uncertainty is not in the results: set "
       "level_sd, use a reference (level_from), or give a plan with [rig] kind = \"shaker\" and its amplitude_sd",
       exposure.label});
}

/// g_rms: set, by the plan, or by the reference.
void set_level(const Evidence& evidence, const Data& data, std::size_t recording, Exposure& exposure,
               Findings& findings) {
  const Settings& settings = evidence.plan.settings;
  const double planned = std::sqrt(variance(exposure.psd));
  const Unit g = Unit::parse("g");
  exposure.rms = settings.has("level") ? settings.number("level") : planned;
  const auto known = level_sd(evidence, recording);
  exposure.rms_sd = exposure.level_sd = known.value_or(0.0);
  const bool wanted = settings.word("level_from") == "reference";
  if (!known && !wanted) say_unknown_level(exposure, findings);
  if (exposure.reference.empty()) {
    if (wanted)
      throw Error(Error::Kind::bad_data, "level_from = \"reference\", and no reference is recorded with the windows");
    return;
  }
  // Instants show all of the vibration, means over the windows the part of it that the windows leave.
  const double expected =
      data.reference_integrated ? std::sqrt(window_variance(exposure.psd, exposure.window)) : planned;
  const double found = planned * standard_deviation(exposure.reference) / expected;
  const double gain_sd = exposure.gain_sd = settings.number("reference_gain_sd");
  const auto n = static_cast<double>(exposure.reference.size());
  const double difference = found / exposure.rms - 1.0;
  const std::string both = fmt::format("{:.5g} g by the reference, {:.5g} g by the {}", g.from_si(found),
                                       g.from_si(exposure.rms), settings.has("level") ? "setting level" : "plan");
  const double limit = 3.0 * std::hypot(exposure.rms_sd, gain_sd, 1.0 / std::sqrt(n));
  if (std::abs(difference) > limit)
    findings.push_back({Severity::warning,
                        fmt::format("root mean square of the vibration {}: {:+.1f} %, more than their uncertainties of "
                                    "{:.1f} % explain; see to the shaker's control, the reference's gain and its "
                                    "bandwidth (the reference's own noise is in it)",
                                    both, 100.0 * difference, 100.0 * limit / 3.0),
                        exposure.label});
  if (!wanted) return;
  exposure.rms = found;
  exposure.rms_sd = gain_sd;
  exposure.from_reference = true;
}

void say_level(const Data& data, const Exposure& exposure, Findings& findings) {
  const Unit g = Unit::parse("g");
  findings.push_back(
      {Severity::info,
       fmt::format(
           "root mean square of the vibration {:.5g} g {}, known to {:.2g} %", g.from_si(exposure.rms),
           !exposure.from_reference ? "as commanded or set"
           : data.reference_integrated
               ? "by the reference, which over the windows shows part of it: the shape of the density is the plan's"
               : "by the reference",
           100.0 * exposure.rms_sd),
       exposure.label});
}

}  // namespace

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
  // By recording, power-up and label: units read at stamps of their own do not begin at the same instant.
  std::map<std::tuple<std::size_t, std::size_t, std::string>, std::vector<std::size_t>> groups;
  std::vector<std::string> problems, without;
  for (std::size_t i = 0; i < data.series.size(); ++i) {
    const Series& series = data.series[i];
    if (series.shake.kind != Motion::Kind::random) continue;
    const std::string where = data.units[series.unit].name + ", " + series.label;
    if (vibration::at_rest(data, series).parts.empty()) {
      if (std::ranges::find(without, series.label) == without.end()) without.push_back(series.label);
    } else if (std::ranges::count_if(series.force, [](double v) { return std::isfinite(v); }) < 512)
      problems.push_back(where + ": fewer than 512 windows, which say nothing of the statistics: vibrate for longer");
    else
      groups[{series.recording, series.power_up, series.label}].push_back(i);
  }
  if (!without.empty())
    problems.push_back(
        fmt::format("{}: no segment at rest in the same power-up and position, so that there is nothing "
                    "to take the pulse error from: record the units with the shaker at rest before and "
                    "after",
                    fmt::join(without, ", ")));
  if (groups.empty() && problems.empty()) problems.emplace_back("the schedule has no random vibration");
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);

  std::map<std::string, std::size_t> times, number;
  for (const auto& [key, members] : groups) ++times[std::get<2>(key)];
  std::vector<Exposure> out;
  for (const auto& [key, members] : groups) {
    const Series& first = data.series[members.front()];
    Exposure exposure;
    exposure.label = first.label;
    // The same segment in several power-ups or recordings.
    if (times[first.label] > 1) exposure.label += fmt::format(" #{}", ++number[first.label]);
    exposure.prefix = groups.size() > 1 ? exposure.label + "." : "";
    exposure.psd = {first.shake.psd_frequency, first.shake.psd};
    exposure.window = first.window, exposure.interval = first.interval;
    exposure.begin = first.begin, exposure.end = first.end;
    exposure.reference = first.reference;
    std::size_t n = first.force.size();
    for (const std::size_t i : members) n = std::min(n, data.series[i].force.size());
    exposure.weights = faded_weights(n, fading);
    for (const std::size_t i : members) exposure.units.push_back(measured_of(data, i, exposure.weights));
    if (!exposure.reference.empty() && data.reference_integrated)
      for (Measured& unit : exposure.units)
        take_off_reference(exposure.reference, evidence.plan.settings.integer("reference_lags"), unit);
    set_level(evidence, data, first.recording, exposure, findings);
    say_level(data, exposure, findings);
    out.push_back(std::move(exposure));
  }
  return out;
}

}  // namespace tumble::random_vibration
