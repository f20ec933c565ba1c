#include "tumble/methods/vibration/faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"
#include "tumble/methods/vibration/scale.hpp"

namespace tumble::vibration {
namespace {

using Severity = Finding::Severity;

/// Greatest specific force of a vibration about its mean, as windows of H show it; of random vibration, 4 standard
/// deviations of the widest band's.
double reach_of(const Motion& shake, double window) {
  if (shake.kind == Motion::Kind::sine) return shake.amplitude * std::abs(sinc(shake.frequency * window));
  double variance = 0.0;
  for (std::size_t i = 1; i < shake.psd.size(); ++i)
    variance +=
        0.5 * (shake.psd[i] + shake.psd[i - 1]) * (shake.psd_frequency[i] - shake.psd_frequency[i - 1]) *
        std::pow(sinc(std::min(0.5 / window, 0.5 * (shake.psd_frequency[i] + shake.psd_frequency[i - 1])) * window), 2);
  return 4.0 * std::sqrt(variance);
}

/// Counts of a window at rest, and per m/s^2.
struct Expected {
  double count = std::nan(""), scale = std::nan("");
};

Expected expected_of(const Settings& settings, const Draft& draft, const Data& data) {
  double sum = 0.0, rest = 0.0, n = 0.0;
  for (const std::size_t s : draft.series) {
    if (!data.series[s].at_rest()) continue;
    for (const double c : data.series[s].force) {
      if (std::isnan(c)) continue;
      sum += c;
      rest += data.series[s].rest;
      ++n;
    }
  }
  Expected expected;
  if (n == 0.0) return expected;
  expected.count = sum / n;
  if (const auto given = given_scale(settings, data.units[data.series[draft.series.front()].unit], *draft.channel))
    expected.scale = *given * draft.windows.window;
  else if (std::abs(rest / n) > 0.2 * 9.80665)
    expected.scale = sum / rest;
  return expected;
}

double spread(const std::vector<double>& values) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const double v : values)
    if (!std::isnan(v)) ++n, sum += v;
  for (const double v : values)
    if (!std::isnan(v)) squares += (v - sum / n) * (v - sum / n);
  return std::sqrt(squares / n);
}

}  // namespace

void unwrap_counts(const Settings& settings, const Draft& draft, Data& data, std::vector<std::string>& problems) {
  if (reading_of(*draft.channel) != Reading::pulses || draft.series.empty()) return;
  const Expected expected = expected_of(settings, draft, data);
  for (const std::size_t s : draft.series) {
    Series& series = data.series[s];
    if (series.at_rest()) continue;
    const double reach = reach_of(series.shake, series.window) * std::abs(expected.scale);
    const Unwrapped result = unwrap(series.force, expected.count, reach);
    if (result.outcome == Unwrapped::Outcome::repaired)
      data.findings.push_back(
          {Severity::warning,
           fmt::format("the counter ran over its {} bits in {}: put right, since all lie well within "
                       "half of 2^{} of the count at rest; use a wider register or a shorter H",
                       result.bits, say_count(result.windows, "window"), result.bits),
           draft.channel->name + ", " + series.label});
    if (result.outcome == Unwrapped::Outcome::ambiguous)
      problems.push_back(
          fmt::format("{}, {}: the counter ran over its {} bits and which windows did cannot be told: use "
                      "a wider register, a shorter counting period or less amplitude",
                      draft.channel->name, series.label, result.bits));
  }
}

void drop_dead(Data& data) {
  std::vector<Series> alive;
  for (auto& series : data.series) {
    double low = INFINITY, high = -INFINITY;
    for (const double v : series.force) {
      if (std::isnan(v)) continue;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    if (!series.at_rest() && !(high > low)) {
      data.findings.push_back({Severity::error,
                               "left out: the unit gives the same value throughout although it is shaken: see to its "
                               "supply and its connection",
                               data.units[series.unit].name + ", " + series.label});
      continue;
    }
    alive.push_back(std::move(series));
  }
  data.series = std::move(alive);
}

void drop_moving(const std::map<std::size_t, std::vector<Draft>>& drafts, Data& data) {
  std::vector<double> quietest(data.units.size(), INFINITY);
  for (const Series& s : data.series)
    if (s.at_rest()) quietest[s.unit] = std::min(quietest[s.unit], spread(s.force));
  std::erase_if(data.series, [&](const Series& s) {
    if (!s.at_rest()) return false;
    const bool pulses = reading_of(*drafts.at(s.unit).front().channel) == Reading::pulses;
    const double own = spread(s.force), least = pulses ? 3.0 / s.window : 1e-3 * std::abs(mean_of(s, 0.0).value);
    if (own <= std::max(20.0 * quietest[s.unit], least)) return false;
    data.findings.push_back(
        {Severity::warning,
         fmt::format("not at rest, as planned: it spreads {:.3g} times as much as the quietest; not "
                     "used as the unit at rest",
                     own / quietest[s.unit]),
         data.units[s.unit].prefix + s.label});
    return true;
  });
}

void set_power_ups(Data& data) {
  std::map<int, std::map<std::pair<std::size_t, std::string>, std::size_t>>
      seen;  // by run: recording of unit and label
  std::map<int, bool> split, repeated;
  for (const Series& s : data.series) {
    const auto [known, first] = seen[s.run].emplace(std::pair(s.unit, s.label), s.recording);
    repeated[s.run] = repeated[s.run] || !first;
    split[s.run] = split[s.run] || seen[s.run].begin()->second != s.recording;
  }
  std::map<std::pair<std::size_t, int>, std::size_t> power_ups;
  for (Series& s : data.series) {
    const bool one = split[s.run] && !repeated[s.run];
    s.power_up = power_ups.emplace(std::pair(one ? 0 : s.recording, s.run), power_ups.size()).first->second;
    if (!one) continue;
    s.end = s.planned_begin + s.end - s.begin;
    s.begin = s.planned_begin;
  }
}

}  // namespace tumble::vibration
