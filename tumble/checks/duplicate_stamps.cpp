#include "tumble/checks/check.hpp"
#include "tumble/checks/support/timelines.hpp"

namespace tumble::checks::duplicate_stamps {

namespace {

using namespace support;

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& timeline : stamped_timelines(recording)) {
    const auto& stamps = *timeline.channel->timeline.stamps;
    std::size_t count = 0, first = 0;
    for (std::size_t i = 1; i < stamps.size(); ++i)
      if (stamps[i] == stamps[i - 1] && count++ == 0) first = i;
    if (count == 0) continue;
    if (count > 1 && count + 1 == stamps.size()) {
      findings.push_back({Finding::Severity::error, "clock_stands_still", {{"stamp", stamps[0], "s"}}, timeline.where});
      continue;
    }
    const bool coarse = 4 * count > stamps.size();
    findings.push_back({Finding::Severity::warning,
                        coarse ? "coarse_stamps" : "duplicate_stamps",
                        {},
                        timeline.where,
                        {count, stamps[first]}});
  }
  return findings;
}

}  // namespace

extern const Check duplicate_stamps{"duplicate_stamps", "samples with the stamp of the sample before", run};

}  // namespace tumble::checks::duplicate_stamps
