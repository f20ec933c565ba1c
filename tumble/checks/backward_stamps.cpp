#include "tumble/checks/check.hpp"
#include "tumble/checks/support/timelines.hpp"

namespace tumble::checks::backward_stamps {

namespace {

using namespace support;

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& timeline : stamped_timelines(recording)) {
    const auto& stamps = *timeline.channel->timeline.stamps;
    std::size_t count = 0, first = 0;
    for (std::size_t i = 1; i < stamps.size(); ++i)
      if (stamps[i] < stamps[i - 1] && count++ == 0) first = i;
    if (count == 0) continue;
    findings.push_back({Finding::Severity::error,
                        "backward_stamps",
                        {{"sample", first}, {"stamp", stamps[first], "s"}, {"before", stamps[first - 1], "s"}},
                        timeline.where,
                        {count, stamps[first]}});
  }
  return findings;
}

}  // namespace

extern const Check backward_stamps{"backward_stamps", "stamps that are earlier than the stamp before", run};

}  // namespace tumble::checks::backward_stamps
