#include "tumble/exchange/test_days.hpp"

#include <algorithm>

#include "tumble/core/instant.hpp"

namespace tumble {
namespace {

std::optional<std::chrono::sys_days> day_of(const std::string& text) {
  using namespace std::chrono;
  const auto time = parse_iso_time(text);
  if (!time) return std::nullopt;
  return floor<days>(sys_time<nanoseconds>(nanoseconds(*time)));
}

}  // namespace

std::vector<RecordingDays> recording_days(const Estimate& estimate) {
  std::vector<RecordingDays> days;
  for (const auto& [file, times] : recording_times(estimate))
    if (const auto begun = day_of(times.begun), ended = day_of(times.ended); begun && ended)
      days.push_back({file, *begun, *ended});
  return days;
}

std::optional<TestDays> test_days(const Estimate& estimate) {
  const auto days = recording_days(estimate);
  if (days.empty() || days.size() < recording_times(estimate).size()) return std::nullopt;
  return TestDays{std::ranges::min(days, {}, &RecordingDays::begun).begun,
                  std::ranges::max(days, {}, &RecordingDays::ended).ended};
}

}  // namespace tumble
