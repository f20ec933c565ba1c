#include "tumble/formats/file/even_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tumble::file {
namespace {

file::EvenClock clock_of(const std::vector<double>& stamps, double place) {
  file::EvenClock clock;
  for (const double t : stamps) clock.add(t, place);
  return clock;
}

std::vector<double> stamps(std::size_t count, double rate, double place, double start = 0.0) {
  std::vector<double> result;
  for (std::size_t k = 0; k < count; ++k) {
    const double t = start + static_cast<double>(k) / rate;
    result.push_back(place > 0.0 ? std::round(t / place) * place : t);
  }
  return result;
}

TEST(EvenClock, PlainRatesComeBackExactly) {
  for (const double rate : {1.0, 3.0, 99.5, 100.0, 128.0, 400.0, 1000.0, 3072.0, 99.98765})
    for (const std::size_t count : {2u, 10u, 5000u}) {
      const auto timeline = clock_of(stamps(count, rate, 0.0, 12.5), 0.0).timeline();
      ASSERT_TRUE(timeline) << rate;
      EXPECT_EQ(timeline->start, 12.5);
      EXPECT_EQ(timeline->rate, rate);
    }
}

TEST(EvenClock, RoundedStampsAreEven) {
  const auto timeline = clock_of(stamps(4000, 400.0, 1e-3), 1e-3).timeline();  // 0.0025 s written to the ms
  ASSERT_TRUE(timeline);
  EXPECT_EQ(timeline->rate, 400.0);
  const auto third = clock_of(stamps(100, 3.0, 1e-6), 1e-6).timeline();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->rate, 3.0);
}

// An interval near the digit: steps of two digits, or of none, come at regular distances.
TEST(EvenClock, StampsRoundedToADigitNearTheIntervalAreEven) {
  for (const double rate : {99.7, 99.95, 99.3, 100.3, 101.0, 66.6, 120.0, 45.7})
    for (const double start : {0.0, 1.7e9}) {
      const auto timeline = clock_of(stamps(20000, rate, 0.01, start), 0.01).timeline();
      ASSERT_TRUE(timeline) << rate;
      EXPECT_NEAR(timeline->rate, rate, 1e-5 * rate) << start;  // half a digit at either end of 20 000 samples
      auto cut = stamps(20000, rate, 0.0, start);
      for (double& t : cut) t = std::floor(t / 0.01) * 0.01;
      ASSERT_TRUE(clock_of(cut, 0.01).timeline()) << rate;
      auto gappy = stamps(20000, rate, 0.01, start);
      gappy.erase(gappy.begin() + 7777);
      EXPECT_FALSE(clock_of(gappy, 0.01).timeline()) << rate;
    }
}

// Two steps of two digits in 1000 samples: lost samples, unless the rate is stated.
TEST(EvenClock, AStatedRateDecidesBetweenALossAndRounding) {
  const auto clock = clock_of(stamps(1000, 99.8, 0.01), 0.01);
  EXPECT_FALSE(clock.timeline());
  EXPECT_FALSE(clock.timeline(100.0));
  ASSERT_TRUE(clock.timeline(99.8));
  EXPECT_EQ(clock.timeline(99.8)->rate, 99.8);
  EXPECT_TRUE(clock.allows({0.0, 99.8, nullptr}));
}

TEST(EvenClock, ClockSummedUpInFloatingPointIsEven) {
  std::vector<double> sums{0.0};
  for (int k = 1; k < 1000000; ++k) sums.push_back(sums.back() + 0.01);
  const auto timeline = clock_of(sums, 1e-17).timeline();
  ASSERT_TRUE(timeline);
  EXPECT_EQ(timeline->rate, 100.0);
}

TEST(EvenClock, AnIntervalThatIsExactIsKept) {
  const auto timeline = clock_of({0.0, 0.013, 0.026, 0.039}, 1e-3).timeline();
  ASSERT_TRUE(timeline);
  EXPECT_DOUBLE_EQ(1.0 / timeline->rate, 0.013);
}

TEST(EvenClock, AnyLostSampleIsSeen) {
  for (const double place : {0.0, 1e-3, 1.0})  // at 1 Hz: exact, to the ms, to the whole second
    for (std::size_t lost = 1; lost < 99; ++lost) {
      auto gappy = stamps(100, 1.0, 0.0);
      gappy.erase(gappy.begin() + static_cast<std::ptrdiff_t>(lost));
      EXPECT_FALSE(clock_of(gappy, place).timeline()) << lost;
    }
}

TEST(EvenClock, BackwardRepeatedAndJitteryStampsAreNotEven) {
  EXPECT_FALSE(clock_of({0, 1, 2, 1.5, 3}, 0.1).timeline());
  EXPECT_FALSE(clock_of({0, 1, 1, 2, 3}, 1.0).timeline());
  EXPECT_FALSE(clock_of({3, 2, 1, 0}, 1.0).timeline());
  EXPECT_FALSE(clock_of({1, 1, 1}, 1.0).timeline());
  EXPECT_FALSE(clock_of({0, 0.0101, 0.0198, 0.0302}, 1e-4).timeline());
  EXPECT_FALSE(clock_of({0.5}, 0.1).timeline());
}

TEST(EvenClock, AStatedClockIsHeldAgainstTheStamps) {
  const auto clock = clock_of(stamps(1000, 3.0, 1e-6), 1e-6);
  EXPECT_TRUE(clock.allows({0.0, 3.0, nullptr}));
  EXPECT_FALSE(clock.allows({0.0, 3.001, nullptr}));
  EXPECT_FALSE(clock.allows({0.1, 3.0, nullptr}));
  EXPECT_FALSE(clock.allows({0.0, 0.0, nullptr}));
}

}  // namespace
}  // namespace tumble::file
