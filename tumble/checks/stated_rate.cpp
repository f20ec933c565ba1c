#include <algorithm>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/counts.hpp"
#include "tumble/checks/support/timelines.hpp"
#include "tumble/clocks/clock.hpp"

namespace tumble {

namespace {

/// How far a channel's own rate is from the stated one, and how far it may be by what its stamps leave open [1].
struct Against {
  const Channel* channel = nullptr;
  double rate = 0.0, difference = INFINITY, open = 0.0;  ///< rate [Hz]
};

Against against(const Channel& channel, double stated) {
  constexpr double as_written = 1e-6;  // of a rate that a file gives in a few digits
  if (channel.values.size() < 3) return {};
  const Clock clock = clock_of(channel);
  if (!(clock.rate > 0.0) || !std::isfinite(clock.rate) || clock.backward > 0 || clock.other_rate > 0.0) return {};
  const double length = span(channel);
  const double open = channel.timeline.uniform() || !(length > 0.0) ? 0.0 : 2.0 * clock.worst / length;
  return {&channel, clock.rate, clock.rate / stated - 1.0, std::max(as_written, open)};
}

/// One channel of each clock.
std::vector<const Channel*> clocks_in(const Recording& recording) {
  std::vector<const Channel*> all;
  for (const auto& timeline : support::stamped_timelines(recording)) all.push_back(timeline.channel);
  for (const Channel& channel : recording.channels)
    if (channel.timeline.uniform()) all.push_back(&channel);
  return all;
}

}  // namespace

Findings against_stated_rate(const Recording& recording, double stated) {
  constexpr double quartz = 1e-4, any_clock = 0.03;  // the latter inside a cheap sensor
  Against nearest;
  for (const Channel* channel : clocks_in(recording)) {
    const Against one = against(*channel, stated);
    if (one.channel && std::abs(one.difference) < std::abs(nearest.difference)) nearest = one;
  }
  const double apart = std::abs(nearest.difference);
  if (!nearest.channel || apart <= nearest.open) return {};
  const bool counts = std::ranges::any_of(recording.channels, support::counts_pulses);
  const bool matters = apart > any_clock || (counts && apart > quartz);
  return {{matters ? Finding::Severity::warning : Finding::Severity::info,
           counts ? "rate_of_counts_differs" : "rate_differs_from_stated",
           {{"rate", nearest.rate, "Hz"}, {"stated", stated, "Hz"}, {"difference", nearest.difference, "ppm"}}}};
}

namespace checks::stated_rate {
namespace {

/// Without a plan, the rate that stands beside the stamps is the stated one.
Findings run(const Recording& recording, const Plan* plan) {
  double stated = plan == nullptr ? 0.0 : plan->reading.rate.value_or(plan->sample_rate);
  if (plan == nullptr)
    for (const auto& timeline : support::stamped_timelines(recording)) stated = timeline.channel->timeline.rate;
  return stated > 0.0 ? against_stated_rate(recording, stated) : Findings{};
}

}  // namespace

extern const Check stated_rate{"stated_rate", "stamps that contradict the rate that is stated", run};

}  // namespace checks::stated_rate
}  // namespace tumble
