#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// The key of Recording::meta under which readers note date and time of the first sample, as iso_time() writes it:
/// "2026-11-20T09:00:00.123Z", local time without the Z. A file that does not say it has none.
inline constexpr const char* clock_start = "clock_start";

/// "2026-11-20T09:00:00.123" for [ns] since 1970-01-01.
std::string iso_time(std::int64_t time);

/// [ns] since 1970-01-01 of a text that iso_time() may have written, with or without a Z; nothing for another text.
std::optional<std::int64_t> parse_iso_time(std::string_view text);

/// Whether a clock that shows this time [ns] since 1970-01-01 was ever set: from 2000 on.
bool is_set(std::int64_t time);

/// Times [s] of the first and the last sample of all channels, on the clock of the recording.
struct Extent {
  double first = std::numeric_limits<double>::infinity(), last = -std::numeric_limits<double>::infinity();

  /// Takes in a recording, or the next block of one.
  void add(const Recording& recording);
};

/// Date and time of the first and the last sample, to the second: "2026-11-20T09:00:00Z". Empty where the recording
/// does not say them, or its clock was never set.
struct TestTimes {
  std::string begun, ended;
};
TestTimes test_times(const std::map<std::string, std::string>& meta, const Extent& extent);

/// A recording of a test.
struct RecordingTimes {
  std::string file;
  TestTimes times;
};
/// The table `recordings` of a result, and what such a result says in it; nothing where it has none.
Table table_of(const std::vector<RecordingTimes>& recordings);
std::vector<RecordingTimes> recording_times(const Estimate& estimate);

}  // namespace tumble
