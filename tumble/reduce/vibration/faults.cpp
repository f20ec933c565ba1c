#include "tumble/reduce/vibration/faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/reduce/vibration/scale.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::vibration {
namespace {

using Severity = Finding::Severity;

constexpr std::size_t fewest_steps = 16;  ///< at rest
/// [pulse] and [1] of the steps that go one way: a running total.
constexpr double total_step = 1.0, total_share = 0.9;
constexpr double least_standstill = 32.0, still_cycles = 2.0;  ///< windows, and cycles of the lowest frequency
constexpr double moves_by = 3.0;                               ///< [least steps] that the others scatter by
/// Scatter at rest of a vibration that goes on: [1] of the quietest rest, [pulse] of a window, and [1] of the mean.
constexpr double over_quietest = 20.0, over_pulses = 3.0, over_mean = 1e-3;

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

}  // namespace

double planned_sd(const Series& series) { return 0.25 * reach_of(series.shake, series.window); }

namespace {

/// Counts of a window at rest, and per m/s^2.
struct Expected {
  double count = std::nan(""), scale = std::nan("");
};

/// Given: vibrating, a series whose fixture stands as it does in the rests that count.
Expected expected_of(const Settings& settings, const Draft& draft, const Data& data, const Series& vibrating) {
  double sum = 0.0, rest = 0.0, n = 0.0;
  for (const std::size_t s : draft.series) {
    if (!data.series[s].at_rest() || !is_same_rest(data.series[s], vibrating)) continue;
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
  else if (std::abs(rest / n) > along_input * standard_gravity)
    expected.scale = sum / rest;
  return expected;
}

}  // namespace

void unwrap_counts(const Settings& settings, const Draft& draft, Data& data, Problems& problems) {
  if (reading_of(*draft.channel) != Reading::pulses || draft.series.empty()) return;
  for (const std::size_t s : draft.series) {
    Series& series = data.series[s];
    if (series.at_rest()) continue;
    const Expected expected = expected_of(settings, draft, data, series);
    const double reach = reach_of(series.shake, series.window) * std::abs(expected.scale);
    const Unwrapped result = unwrap(series.force, expected.count, reach);
    if (result.outcome == Unwrapped::Outcome::repaired)
      data.findings.push_back({Severity::warning,
                               "counter_overflow_corrected",
                               {{"bits", result.bits}, {"windows", result.windows}},
                               draft.channel->name + ", " + series.label});
    if (result.outcome == Unwrapped::Outcome::ambiguous)
      problems.push_back(
          say("{}, {}: the counter passed the end of its {} bits, and the data do not show in which windows: "
              "use a wider register, a shorter counting period or less amplitude",
              Name{draft.channel->name}, Name{series.label}, result.bits));
  }
}

void refuse_totals(const Draft& draft, const Data& data, Problems& problems) {
  if (reading_of(*draft.channel) != Reading::pulses) return;
  std::vector<double> steps;
  for (const std::size_t s : draft.series) {
    const Series& series = data.series[s];
    if (!series.at_rest()) continue;
    for (std::size_t j = 1; j < series.force.size(); ++j)
      if (const double step = series.force[j] - series.force[j - 1]; !std::isnan(step)) steps.push_back(step);
  }
  if (steps.size() < fewest_steps) return;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  const double step = *middle;
  const auto alike = std::ranges::count_if(steps, [&](double other) { return other * step > 0.0; });
  // Noise has as many down as up, and no drift is as fast.
  if (std::abs(step) >= total_step && static_cast<double>(alike) > total_share * static_cast<double>(steps.size()))
    problems.push_back(
        say("'{}': at rest the counts grow by {:.4g} from window to window: they are a running "
            "total; record the pulses of each window, or take the differences",
            draft.channel->name, step));
}

namespace {

/// Consecutive windows of one value.
struct Standstill {
  std::size_t begin = 0, length = 0;
  double value = 0.0;
};

/// The longest standstill; missing windows do not end it.
Standstill longest_standstill(const std::vector<double>& values) {
  Standstill current, longest;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (current.length == 0 || values[i] != current.value) current = {i, 0, values[i]};
    ++current.length;
    if (current.length > longest.length) longest = current;
  }
  return longest;
}

/// Whether a series has this value throughout; missing windows do not count.
bool constant(const Series& series, const Standstill& still) {
  return std::ranges::all_of(series.force, [&](double v) { return std::isnan(v) || v == still.value; });
}

/// Whether a unit that is shaken stands still for longer than flat tops and coarse counts explain: two cycles, 32
/// windows, while elsewhere it moves by more than three of its least steps.
bool stands_still(const Series& series, const Standstill& still) {
  const double lowest = series.shake.kind == Motion::Kind::random ? 0.0 : series.shake.frequency;
  const double cycles = lowest > 0.0 ? still_cycles / (lowest * series.interval) : 0.0;
  if (static_cast<double>(still.length) < std::max(least_standstill, cycles)) return false;
  double least = INFINITY, last = std::nan("");
  for (const double v : series.force) {
    if (std::isnan(v)) continue;
    if (v != last && !std::isnan(last)) least = std::min(least, std::abs(v - last));
    last = v;
  }
  return !std::isfinite(least) || spread(series.force) > moves_by * least;
}

}  // namespace

void drop_dead(Data& data) {
  std::vector<std::pair<std::size_t, double>> died;  // unit, value
  std::vector<Series> alive;
  for (auto& series : data.series) {
    const Standstill still = longest_standstill(series.force);
    if (series.at_rest() || !stands_still(series, still)) {
      alive.push_back(std::move(series));
      continue;
    }
    died.emplace_back(series.unit, still.value);
    if (constant(series, still))
      data.findings.push_back({Severity::error, "unit_dead", {}, place_of(data, series)});
    else
      data.findings.push_back({Severity::error,
                               "unit_dies",
                               {{"windows", still.length}, {"begin", series.time[still.begin], "s"}},
                               place_of(data, series)});
  }
  std::erase_if(alive, [&](const Series& series) {
    const Standstill still = longest_standstill(series.force);
    return series.at_rest() && constant(series, still) &&
           std::ranges::find(died, std::pair(series.unit, still.value)) != died.end();
  });
  data.series = std::move(alive);
}

void drop_moving(const std::map<std::size_t, std::vector<Draft>>& drafts, Data& data) {
  std::vector<double> quietest(data.units.size(), INFINITY);
  for (const Series& s : data.series)
    if (s.at_rest()) quietest[s.unit] = std::min(quietest[s.unit], spread(s.force));
  std::erase_if(data.series, [&](const Series& s) {
    if (!s.at_rest()) return false;
    const bool pulses = reading_of(*drafts.at(s.unit).front().channel) == Reading::pulses;
    const double own = spread(s.force),
                 least = pulses ? over_pulses / s.window : over_mean * std::abs(mean_of(s, 0.0).value);
    if (own <= std::max(over_quietest * quietest[s.unit], least)) return false;
    data.findings.push_back(
        {Severity::warning, "moves_at_rest", {{"ratio", own / quietest[s.unit]}}, place_of(data, s)});
    return true;
  });
}

void set_power_ups(Data& data) {
  std::map<int, std::map<std::pair<std::size_t, std::string>, std::size_t>>
      recording_of;  // by run, then by unit and label
  std::map<int, bool> split, repeated;
  for (const Series& s : data.series) {
    const bool first = recording_of[s.run].emplace(std::pair(s.unit, s.label), s.recording).second;
    repeated[s.run] = repeated[s.run] || !first;
    split[s.run] = split[s.run] || recording_of[s.run].begin()->second != s.recording;
  }
  std::map<std::pair<std::size_t, int>, std::size_t> power_ups;
  for (Series& s : data.series) {
    const bool joined = split[s.run] && !repeated[s.run];
    s.power_up = power_ups.emplace(std::pair(joined ? 0 : s.recording, s.run), power_ups.size()).first->second;
    if (!joined) continue;
    s.end = s.planned_begin + s.end - s.begin;
    s.begin = s.planned_begin;
  }
}

}  // namespace tumble::vibration
