#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"

namespace tumble {

/// First and last day of a recording, by its own clock.
struct RecordingDays {
  std::string file;
  std::chrono::sys_days begun, ended;
};
/// Days of the recordings that state them.
std::vector<RecordingDays> recording_days(const Estimate& estimate);

/// First and last day of a test. Nothing unless each recording says its days: those of some are not those of the test.
struct TestDays {
  std::chrono::year_month_day begun, ended;
};
std::optional<TestDays> test_days(const Estimate& estimate);

}  // namespace tumble
