#include <algorithm>

#include "tumble/checks/check.hpp"
#include "tumble/checks/support/segments.hpp"
#include "tumble/checks/support/timelines.hpp"
#include "tumble/clocks/clock.hpp"

namespace tumble::checks::gaps {

namespace {

using namespace support;

Finding finding(const std::vector<Clock::Gap>& gaps, const std::string& where) {
  std::size_t lost = 0;
  for (const auto& gap : gaps) lost += gap.lost;
  const auto& longest = *std::ranges::max_element(gaps, {}, &Clock::Gap::lost);
  return {Finding::Severity::warning,
          "gap",
          {{"lost", lost}, {"longest", longest.length, "s"}},
          where,
          {gaps.size(), gaps.front().begin, longest.begin}};
}

/// Two rates explain the stamps.
Finding unclear(const Clock& clock, const std::string& where) {
  return {Finding::Severity::warning,
          "rate_unclear",
          {{"rate", clock.rate, "Hz"}, {"other", clock.other_rate, "Hz"}},
          where};
}

Findings run(const Recording& recording, const Plan*) {
  Findings findings;
  for (const auto& timeline : stamped_timelines(recording)) {
    Clock clock = clock_of(*timeline.channel);
    if (clock.other_rate > 0.0) findings.push_back(unclear(clock, timeline.where));
    const double sample = clock.rate > 0.0 ? 1.0 / clock.rate : 0.0;
    std::erase_if(clock.gaps, [&](const Clock::Gap& gap) {
      return is_between_segments(recording, gap.begin + sample, gap.begin + gap.length - sample);
    });
    if (clock.backward == 0 && !clock.gaps.empty()) findings.push_back(finding(clock.gaps, timeline.where));
  }
  return findings;
}

}  // namespace

extern const Check gaps{"gaps", "pauses in the stamps after which samples are missing", run};

}  // namespace tumble::checks::gaps
