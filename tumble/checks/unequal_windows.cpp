#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/counts.hpp"

namespace tumble::checks::unequal_windows {

namespace {

using namespace support;

constexpr double least_pairs = 64.0;    ///< changes that give a slope and its scatter to an eighth
constexpr double most_departure = 0.5;  ///< [mean intervals] of a window that is used: beyond it a stamp is missing
/// [1] rms of the intervals over their mean. Chosen: 100 ppm of a scale factor, which the check stated_rate
/// accepts beside counts.
constexpr double least_scatter = 1e-4;
/// [1] sd of the slope, for which 1 (counts that go with the interval) and 0 (stamps that are late) lie ten sd apart.
constexpr double most_sd = 0.1;
/// [1] about the slope 1: nearer to it than to 0. Chosen: doubled, a mixture of late stamps and unequal windows is
/// a finding too.
constexpr double slope_tolerance = 0.3;
constexpr double slope_sd = 4.0;  ///< standard deviations of the slope in addition: 6e-5 of true findings are missed

/// Counts against the time to the next stamp, both as changes from the pair before, so that slow motion drops out.
struct Slope {
  double value = 0.0, sd = INFINITY;
  double scatter = 0.0;  ///< rms of the intervals over their mean
};

Slope slope_of(const Channel& channel) {
  const auto& n = channel.values;
  const std::size_t size = n.size();
  double intervals = 0.0, counts = 0.0, used = 0.0;
  for (std::size_t i = 0; i + 1 < size; ++i) {
    if (!std::isfinite(n[i])) continue;
    intervals += channel.time(i + 1) - channel.time(i);
    counts += n[i];
    ++used;
  }
  if (used < least_pairs || !(intervals > 0.0) || counts == 0.0) return {};
  const double interval = intervals / used, count = counts / used;
  double xx = 0.0, xy = 0.0, yy = 0.0, pairs = 0.0;
  for (std::size_t i = 1; i + 1 < size; ++i) {
    const double a = (channel.time(i + 1) - channel.time(i)) / interval,
                 b = (channel.time(i) - channel.time(i - 1)) / interval;
    if (!std::isfinite(n[i] - n[i - 1])) continue;
    if (std::abs(a - 1.0) > most_departure || std::abs(b - 1.0) > most_departure) continue;
    const double x = a - b, y = (n[i] - n[i - 1]) / count;
    xx += x * x, xy += x * y, yy += y * y;
    ++pairs;
  }
  if (pairs < least_pairs || !(xx > 0.0)) return {};
  const double value = xy / xx;
  return {value, std::sqrt(std::max(0.0, yy - value * xy) / pairs / xx), std::sqrt(0.5 * xx / pairs)};
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const Channel& channel : recording.channels) {
    if (!counts_pulses(channel) || channel.timeline.uniform() || !spread_of(channel).whole) continue;
    const Slope slope = slope_of(channel);
    // The slope is 1 for counts that go with the interval and 0 for stamps that are merely late.
    if (!(slope.scatter > least_scatter) || !(slope.sd < most_sd)) continue;
    if (std::abs(slope.value - 1.0) > slope_tolerance + slope_sd * slope.sd) continue;
    findings.push_back(
        {Finding::Severity::warning, "unequal_windows", {{"scatter", slope.scatter, "%"}}, channel.name});
  }
  return findings;
}

}  // namespace

extern const Check unequal_windows{"unequal_windows", "counting windows of unequal length, which the counts follow",
                                   run};

}  // namespace tumble::checks::unequal_windows
