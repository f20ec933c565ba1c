#include <fmt/format.h>

#include <algorithm>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/timelines.hpp"
#include "tumble/core/clock.hpp"
#include "tumble/core/say.hpp"

namespace tumble::checks {

namespace {

using namespace support;

std::string sentence(std::vector<Clock::Gap> gaps) {
  std::size_t lost = 0;
  for (const auto& gap : gaps) lost += gap.lost;
  std::stable_sort(gaps.begin(), gaps.end(), [](const auto& a, const auto& b) { return a.lost > b.lost; });
  if (gaps.size() == 1)
    return fmt::format("gap of {} at {}: {} lost", say_seconds(gaps[0].length), say_instant(gaps[0].begin),
                       say_count(lost, "sample"));
  std::string longest;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, gaps.size()); ++i)
    longest += fmt::format("{}{} at {}", i == 0 ? "" : ", ", say_seconds(gaps[i].length), say_instant(gaps[i].begin));
  return fmt::format("{} gaps, {} lost; the longest: {}", gaps.size(), say_count(lost, "sample"), longest);
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& timeline : stamped_timelines(recording)) {
    const Clock clock = clock_of(*timeline.channel);
    if (!clock.gaps.empty())
      findings.push_back({Finding::Severity::warning,
                          sentence(clock.gaps) + "; methods that need a constant rate cannot use data across a gap",
                          timeline.where});
  }
  return findings;
}

}  // namespace

extern const Check gaps{"gaps", "pauses in the stamps after which samples are missing", run};

}  // namespace tumble::checks
