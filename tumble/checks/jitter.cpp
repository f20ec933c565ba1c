#include "tumble/checks/check.hpp"
#include "tumble/checks/support/timelines.hpp"
#include "tumble/core/clock.hpp"
#include "tumble/core/say.hpp"

namespace tumble::checks {

namespace {

using namespace support;

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& timeline : stamped_timelines(recording)) {
    const Clock clock = clock_of(*timeline.channel);
    if (!clock.gaps.empty() || clock.backward > 0 || timeline.channel->values.size() < 3) continue;  // said elsewhere
    if (!clock.even) {
      findings.push_back({Finding::Severity::warning, "not evenly sampled: " + clock.reason, timeline.where});
    } else if (clock.jitter_rms * clock.rate > 0.05) {
      std::string message = clock.reason;
      if (clock.longest_pause * clock.rate > 2.0)
        message += ", with pauses of up to " + say_seconds(clock.longest_pause) + " (at " +
                   say_instant(timeline.channel->time(clock.pause_after)) + ") in which no sample was lost";
      findings.push_back({Finding::Severity::info, message + ": treated as evenly sampled", timeline.where});
    }
  }
  return findings;
}

}  // namespace

extern const Check jitter{"jitter", "stamps that scatter, about an even clock or without one", run};

}  // namespace tumble::checks
