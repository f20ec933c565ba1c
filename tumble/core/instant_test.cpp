#include "tumble/core/instant.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

constexpr std::int64_t second = 1'000'000'000;

TEST(Instant, IsWrittenAndReadBack) {
  for (const std::int64_t time : {std::int64_t{0}, 1'700'000'000 * second, 1'700'000'000 * second + 120'000'000,
                                  951'782'400 * second + 1, -second / 2})
    EXPECT_EQ(parse_iso_time(iso_time(time)), time) << iso_time(time);
  EXPECT_EQ(iso_time(951'782'400 * second + 1), "2000-02-29T00:00:00.000000001");
  EXPECT_EQ(parse_iso_time("2023-11-14T22:13:20Z"), 1'700'000'000 * second);
}

TEST(Instant, IsWrittenToTheSecondAndToTheDay) {
  const std::int64_t time = 951'782'400 * second;
  EXPECT_EQ(iso_second(time + 999'999'999), "2000-02-29T00:00:00Z");
  EXPECT_EQ(iso_second(-1), "1969-12-31T23:59:59Z");
  EXPECT_EQ(iso_day(time - 1), "2000-02-28");
  EXPECT_EQ(iso_time(time + 120'000'000), "2000-02-29T00:00:00.12");
}

TEST(Instant, IsNotReadFromOtherTexts) {
  for (const char* text :
       {"", "Z", "2023-11-14", "2023-11-14T22:13", "2023-11-14 22:13:20", "2023-02-29T00:00:00", "2023-13-01T00:00:00",
        "2023-11-14T24:00:00", "2023-11-14T22:13:20.", "2023-11-14T22:13:20+1", "2023-11-14T22:13:20.1234567890",
        "0000-01-01T00:00:00", "2023-11-14T22:13:-1"})
    EXPECT_FALSE(parse_iso_time(text)) << text;
}

Recording of_ten_seconds(const std::string& start) {
  Recording recording;
  recording.channels = {{"a", QuantityKind::other, {}, {100.0, 10.0, nullptr}, std::vector<double>(101, 0.0)}};
  if (!start.empty()) recording.meta[clock_start] = start;
  return recording;
}

TestTimes times_of(const Recording& recording) {
  Extent extent;
  extent.add(recording);
  return test_times(recording.meta, extent);
}

TEST(TestTimes, LastAsLongAsTheSamples) {
  const auto [begun, ended] = times_of(of_ten_seconds("2026-11-20T23:59:55.75Z"));
  EXPECT_EQ(begun, "2026-11-20T23:59:55Z");
  EXPECT_EQ(ended, "2026-11-21T00:00:05Z");
  EXPECT_EQ(times_of(of_ten_seconds("2026-11-20T09:00:00")).ended, "2026-11-20T09:00:10");  // local time stays local
}

TEST(TestTimes, AreNotInvented) {
  EXPECT_EQ(times_of(of_ten_seconds("")).begun, "");
  EXPECT_EQ(times_of(of_ten_seconds("1970-01-01T00:00:12Z")).begun, "");  // a clock that was never set
  EXPECT_EQ(times_of(of_ten_seconds("yesterday")).begun, "");
  Recording without = of_ten_seconds("2026-11-20T09:00:00");
  without.channels.clear();
  EXPECT_EQ(times_of(without).begun, "");
}

TEST(TestTimes, OfBlocksAreThoseOfAllOfThem) {
  Recording block = of_ten_seconds("2026-11-20T09:00:00");
  Extent extent;
  extent.add(block);
  block.channels[0].timeline.start = 200.0;
  extent.add(block);
  EXPECT_EQ(test_times(block.meta, extent).ended, "2026-11-20T09:01:50");
}

}  // namespace
}  // namespace tumble
