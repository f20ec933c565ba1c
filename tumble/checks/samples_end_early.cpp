#include <algorithm>
#include <cmath>

#include "tumble/checks/check.hpp"

namespace tumble::checks::samples_end_early {

namespace {

constexpr double latency = 0.5;         ///< [s] of a stream whose last samples came behind the end of a segment
constexpr double latent_samples = 3.0;  ///< or so many samples

/// Where the last sample of a recording ends [s], and how much later a segment may end.
struct LastSample {
  double end = -INFINITY, allowed = latency;
};

LastSample last_sample_of(const Recording& recording) {
  LastSample last;
  for (const Channel& channel : recording.channels) {
    const double rate = mean_rate(channel);
    if (channel.values.empty() || !(rate > 0.0)) continue;
    last.end = std::max(last.end, channel.time(channel.values.size() - 1) + 1.0 / rate);
    last.allowed = std::max(last.allowed, latent_samples / rate);
  }
  return last;
}

bool ends_as_planned(const Mark& mark, const Plan& plan) {
  return std::ranges::any_of(plan.schedule, [&](const Segment& segment) {
    return segment.label == mark.label && mark.begin + segment.duration == mark.end;
  });
}

/// A mark that says no end claims samples at its beginning only. One whose end only the plan says (tasks/marks.cpp) claims
/// none: a record that is shorter than the plan is what `schedule_mismatch` names.
double claimed_until(const Mark& mark, const Plan* plan) {
  if (std::isfinite(mark.end)) return plan != nullptr && ends_as_planned(mark, *plan) ? -INFINITY : mark.end;
  return plan == nullptr ? mark.begin : -INFINITY;
}

Findings find_silence_at_the_end(const Recording& recording, const Plan* plan) {
  const LastSample last = last_sample_of(recording);
  if (!std::isfinite(last.end)) return {};
  std::size_t count = 0;
  const Mark* first = nullptr;
  double until = last.end;
  for (const Mark& mark : recording.marks) {
    if (mark.label.empty() || claimed_until(mark, plan) <= last.end + last.allowed) continue;
    if (count++ == 0) first = &mark;
    until = std::max(until, claimed_until(mark, plan));
  }
  if (count == 0) return {};
  return {{Finding::Severity::warning,
           "samples_end_early",
           {{"segment", first->label}, {"end", last.end, "s"}, {"until", until, "s"}},
           "",
           {count, first->begin}}};
}

}  // namespace

extern const Check samples_end_early{"samples_end_early", "segments that go on behind the last sample",
                                     find_silence_at_the_end};

}  // namespace tumble::checks::samples_end_early
