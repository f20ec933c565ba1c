#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/counts.hpp"

namespace tumble::checks::unequal_windows {

namespace {

using namespace support;

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
  if (used < 64.0 || !(intervals > 0.0) || counts == 0.0) return {};
  const double interval = intervals / used, count = counts / used;
  double xx = 0.0, xy = 0.0, yy = 0.0, pairs = 0.0;
  for (std::size_t i = 1; i + 1 < size; ++i) {
    const double a = (channel.time(i + 1) - channel.time(i)) / interval,
                 b = (channel.time(i) - channel.time(i - 1)) / interval;
    if (!std::isfinite(n[i] - n[i - 1]) || std::abs(a - 1.0) > 0.5 || std::abs(b - 1.0) > 0.5) continue;
    const double x = a - b, y = (n[i] - n[i - 1]) / count;
    xx += x * x, xy += x * y, yy += y * y;
    ++pairs;
  }
  if (pairs < 64.0 || !(xx > 0.0)) return {};
  const double value = xy / xx;
  return {value, std::sqrt(std::max(0.0, yy - value * xy) / pairs / xx), std::sqrt(0.5 * xx / pairs)};
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const Channel& channel : recording.channels) {
    if (!counts_pulses(channel) || channel.timeline.uniform() || !spread_of(channel).whole) continue;
    const Slope slope = slope_of(channel);
    // One for counts that go with the interval, none for stamps that are merely late.
    if (!(slope.scatter > 1e-4) || !(slope.sd < 0.1) || std::abs(slope.value - 1.0) > 0.3 + 4.0 * slope.sd) continue;
    findings.push_back(
        {Finding::Severity::warning, "unequal_windows", {{"scatter", slope.scatter, "%"}}, channel.name});
  }
  return findings;
}

}  // namespace

extern const Check unequal_windows{"unequal_windows", "counting windows of unequal length, which the counts follow",
                                   run};

}  // namespace tumble::checks::unequal_windows
