#include "tumble/checks/check.hpp"
#include "tumble/checks/support/timelines.hpp"
#include "tumble/clocks/clock.hpp"

namespace tumble::checks::jitter {

namespace {

using namespace support;

/// [sample intervals] rms scatter of the stamps about their clock from which on it is a finding. Chosen: 5 % moves the
/// phase of a tone at a tenth of the rate by 2 degrees. Doubled, scatter up to a tenth of an interval is not reported.
constexpr double least_jitter = 0.05;
/// [sample intervals] between two stamps that make a pause: the place of one sample is empty then.
constexpr double least_pause = 2.0;

Finding uneven(const Clock& clock, const std::string& where) {
  if (clock.rate_change > 0.0)
    return {Finding::Severity::warning, "rate_not_constant", {{"change", clock.rate_change, "%"}}, where};
  if (clock.scatter > 0.0)
    return {Finding::Severity::warning,
            "irregular_samples",
            {{"samples", clock.scatter_samples}, {"scatter", clock.scatter, "%"}},
            where};
  return {Finding::Severity::warning, "stamps_do_not_advance", {}, where};
}

Finding scattered(const Clock& clock, const StampedTimeline& timeline) {
  const bool pauses = clock.longest_pause * clock.rate > least_pause;
  return {Finding::Severity::info,
          pauses ? "jitter_with_pauses" : "jitter",
          {{"jitter", clock.jitter_rms, "s"}, {"rate", clock.rate, "Hz"}, {"pause", clock.longest_pause, "s"}},
          timeline.where,
          {1, {}, pauses ? Place(timeline.channel->time(clock.pause_after)) : Place()}};
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& timeline : stamped_timelines(recording)) {
    const Clock clock = clock_of(*timeline.channel);
    const auto& stamps = *timeline.channel->timeline.stamps;
    const bool stands = stamps.empty() || stamps.front() == stamps.back();
    if (!clock.gaps.empty() || clock.backward > 0 || stamps.size() < 3 || stands) continue;  // said elsewhere
    if (!clock.even)
      findings.push_back(uneven(clock, timeline.where));
    else if (clock.jitter_rms * clock.rate > least_jitter)
      findings.push_back(scattered(clock, timeline));
  }
  return findings;
}

}  // namespace

extern const Check jitter{"jitter", "stamps that scatter, about an even clock or without one", run};

}  // namespace tumble::checks::jitter
