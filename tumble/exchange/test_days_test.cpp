#include "tumble/exchange/test_days.hpp"

#include <gtest/gtest.h>

#include "tumble/core/instant.hpp"

namespace tumble {
namespace {

using namespace std::chrono_literals;

Estimate with(const std::vector<RecordingTimes>& times) {
  Estimate estimate;
  estimate.tables.push_back(table_of(times));
  return estimate;
}

TEST(TestDays, GoFromTheFirstToTheLastOfAllRecordings) {
  const auto days = test_days(with({{"b", {"2026-11-02T09:00:00", "2026-11-03T00:00:00"}},
                                    {"a", {"2026-11-01T23:59:59Z", "2026-11-02T00:10:00Z"}}}));
  ASSERT_TRUE(days);
  EXPECT_EQ(days->begun, 2026y / 11 / 1);
  EXPECT_EQ(days->ended, 2026y / 11 / 3);
}

TEST(TestDays, AreUnknownWhereARecordingDoesNotSayThem) {
  EXPECT_FALSE(test_days(Estimate{}));
  EXPECT_FALSE(test_days(with({{"a", {"2026-11-01T23:59:59Z", "2026-11-02T00:10:00Z"}}, {"b", {}}})));
  EXPECT_FALSE(test_days(with({{"a", {"today", "tomorrow"}}})));
  Estimate damaged = with({{"a", {"2026-11-01T23:59:59Z", "2026-11-02T00:10:00Z"}}});
  damaged.tables[0].rows[0] = {1.0};
  EXPECT_FALSE(test_days(damaged));
}

}  // namespace
}  // namespace tumble
