#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/counts.hpp"
#include "tumble/core/say.hpp"

namespace tumble::checks {

namespace {

/// Median and greatest departure from it of the four counts on either side of a window.
struct Neighbours {
  double median = 0.0, scatter = 0.0;
};

Neighbours neighbours_of(const std::vector<double>& values, std::size_t i) {
  std::array<double, 8> near;
  for (std::size_t k = 0; k < 4; ++k) {
    near[k] = values[i - 4 + k];
    near[4 + k] = values[i + 1 + k];
  }
  std::ranges::sort(near);
  // One of them may be the empty window that belongs to this one.
  const double median = 0.5 * (near[3] + near[4]);
  return {median, std::max(near[6] - median, median - near[1])};
}

/// Windows that hold k = 2, 3, ... times what their quiet neighbours hold: the card was read too late, and counted on.
struct Late {
  std::size_t windows = 0, missed = 0, first = 0;
  double times = 0.0;
};

Late late_reads(const Channel& channel) {
  Late late;
  const auto& values = channel.values;
  for (std::size_t i = 4; i + 4 < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const Neighbours near = neighbours_of(values, i);
    const double size = std::abs(near.median);
    if (!(size >= 16.0) || !(near.scatter <= 0.1 * size)) continue;
    const double times = values[i] / near.median, whole = std::round(times);
    if (whole < 2.0 || whole > 1000.0 || std::abs(values[i] - whole * near.median) > whole * (near.scatter + 2.0))
      continue;
    if (late.windows++ == 0) late.first = i, late.times = whole;
    late.missed += static_cast<std::size_t>(whole) - 1;
  }
  return late;
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const Channel& channel : recording.channels) {
    if (!counts_pulses(channel) || !spread_of(channel).whole) continue;
    const Late late = late_reads(channel);
    if (late.windows == 0) continue;
    findings.push_back(
        {Finding::Severity::warning,
         fmt::format("{} the pulses of several ({:.0f} times those of its neighbours at {}), {} missed: the card was "
                     "read too late and counted on; leave such windows blank, or share their pulses among those missed",
                     late.windows == 1 ? "one window holds" : fmt::format("{} windows hold", late.windows), late.times,
                     say_instant(channel.time(late.first)), say_count(late.missed, "window")),
         channel.name});
  }
  return findings;
}

}  // namespace

extern const Check missed_windows;
const Check missed_windows{"missed_windows", "pulse counts that hold the pulses of several counting windows", run};

}  // namespace tumble::checks
