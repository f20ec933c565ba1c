#include "tumble/reduce/linear/slow.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "tumble/math/noise_model.hpp"

namespace tumble::linear {
namespace {

using Covariance = std::function<double(const Interval& first, const Interval& second, bool same)>;

/// The kernel of pairs within one power-up, `first` the earlier one.
Matrix kernel_of(const std::vector<Interval>& intervals, const Covariance& covariance) {
  Matrix kernel(intervals.size(), intervals.size());
  for (std::size_t a = 0; a < intervals.size(); ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      if (intervals[a].power_up != intervals[b].power_up) continue;
      const bool ordered = intervals[b].begin <= intervals[a].begin;
      kernel(a, b) = kernel(b, a) =
          ordered ? covariance(intervals[b], intervals[a], a == b) : covariance(intervals[a], intervals[b], a == b);
    }
  return kernel;
}

double random_walk(const Interval& first, const Interval&, bool same) {
  return first.begin + first.length * (same ? 1.0 / 3.0 : 0.5);
}

double markov(const MarkovComponent& component, const Interval& first, const Interval& second, bool same) {
  const double r = first.length / component.time, q = second.length / component.time;
  const double variance = component.sd * component.sd;
  if (same) return variance * markov_mean_variance(r);
  const double gap = std::max(0.0, second.begin - first.begin - first.length);
  return variance * std::exp(-gap / component.time) * std::expm1(-r) * std::expm1(-q) / (r * q);
}

Matrix same_power_up(const std::vector<Interval>& intervals) {
  return kernel_of(intervals, [](const Interval&, const Interval&, bool) { return 1.0; });
}

std::size_t power_ups_in(const std::vector<Interval>& intervals) {
  std::set<std::size_t> power_ups;
  for (const auto& interval : intervals) power_ups.insert(interval.power_up);
  return power_ups.size();
}

/// How long the longest power-up is looked at: not its latest time, which depends on where a clock begins.
double longest_of(const std::vector<Interval>& intervals) {
  std::map<std::size_t, std::pair<double, double>> looks;
  for (const auto& interval : intervals) {
    const double end = interval.begin + interval.length;
    const auto look = looks.try_emplace(interval.power_up, interval.begin, end).first;
    look->second = {std::min(look->second.first, interval.begin), std::max(look->second.second, end)};
  }
  double longest = 0.0;
  for (const auto& [power_up, look] : looks) longest = std::max(longest, look.second - look.first);
  return longest;
}

constexpr const char* turn_on = "turn-on repeatability";

}  // namespace

std::vector<SlowNoise> unknown_slow_noise(const std::vector<Interval>& intervals, std::size_t parameters, double step,
                                          double bias_instability) {
  std::vector<SlowNoise> slow;
  slow.push_back({drift_source,
                  kernel_of(intervals, [](const Interval&, const Interval&, bool same) { return same ? 1.0 : 0.0; })});
  const bool stated = bias_instability > 0.0;
  // Two variances more than the parameters: some more segments are needed to distinguish them.
  const bool shown = intervals.size() >= parameters + 4;
  if (shown || stated) {
    const auto bank = flicker_bank(1.0, step / 4.0, 4.0 * longest_of(intervals));
    const Matrix kernel = kernel_of(intervals, [&](const Interval& first, const Interval& second, bool same) {
      double sum = 0.0;
      for (const auto& component : bank) sum += markov(component, first, second, same);
      return sum;
    });
    if (shown) slow.push_back({drift_source, kernel});
    if (stated) slow.push_back({stated_source, kernel, bias_instability * bias_instability, true});
  }
  if (power_ups_in(intervals) > 1) slow.push_back({turn_on, same_power_up(intervals)});
  return slow;
}

std::vector<SlowNoise> known_slow_noise(const std::vector<Interval>& intervals, const NoiseModel& noise,
                                        double turn_on_sd, double step) {
  std::vector<MarkovComponent> bank;
  if (noise.bias_instability > 0.0)
    bank = flicker_bank(noise.bias_instability, step / 4.0, 4.0 * longest_of(intervals));
  if (noise.markov_sd > 0.0) bank.push_back({noise.markov_sd, noise.markov_time});
  const double walk = noise.rate_random_walk * noise.rate_random_walk;
  const double quantization = noise.quantization_noise * noise.quantization_noise;
  const auto covariance = [&](const Interval& first, const Interval& second, bool same) {
    double sum = walk * random_walk(first, second, same);
    for (const auto& component : bank) sum += markov(component, first, second, same);
    if (same) sum += 2.0 * quantization / (first.length * first.length);
    return sum;
  };
  std::vector<SlowNoise> slow{{drift_source, kernel_of(intervals, covariance), 1.0}};
  if (turn_on_sd > 0.0) slow.push_back({turn_on, same_power_up(intervals), turn_on_sd * turn_on_sd});
  return slow;
}

}  // namespace tumble::linear
