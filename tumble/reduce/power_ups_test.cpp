#include "tumble/reduce/power_ups.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/math/random.hpp"
#include "tumble/reduce/held_samples.hpp"
#include "tumble/reduce/lost_by_value.hpp"
#include "tumble/reduce/zeros.hpp"

namespace tumble {
namespace {

std::vector<PowerUpValue> power_ups(std::size_t count, std::uint64_t seed) {
  std::vector<PowerUpValue> values;
  for (std::size_t k = 0; k < count; ++k)
    values.push_back({"run" + std::to_string(k + 1), si(1.0, "deg/h") * RandomStream(seed).normal(k), 0.0});
  return values;
}

Matrix constant_of(std::size_t count) {
  Matrix one(count, 1);
  for (double& value : one.values) value = 1.0;
  return one;
}

Findings found_in(const std::vector<PowerUpValue>& values) {
  return uneven_power_ups(values, constant_of(values.size()), Unit::parse("deg/h"));
}

TEST(PowerUps, ATrendAndAnOutlierAreSaid) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    auto drifting = power_ups(10, seed), one = power_ups(10, seed);
    for (std::size_t k = 0; k < 10; ++k) drifting[k].value += si(3.0, "deg/h") * static_cast<double>(k);
    one[4].value += si(20.0, "deg/h");
    ASSERT_EQ(found_in(drifting).size(), 1u) << seed;
    EXPECT_EQ(found_in(drifting)[0].code, "power_ups_drift");
    ASSERT_EQ(found_in(one).size(), 1u) << seed;
    EXPECT_EQ(found_in(one)[0].code, "power_up_differs");
    EXPECT_EQ(found_in(one)[0].where, "run5");
  }
}

TEST(PowerUps, ChanceIsNeitherTrendNorOutlier) {
  int said = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) said += found_in(power_ups(4 + seed % 8, seed)).empty() ? 0 : 1;
  EXPECT_LE(said, 8);  // 2 expected, p = 1e-3
}

TEST(PowerUps, OneInTwentySoundTestsHasADoubtfulOne) {
  int doubtful = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    auto values = power_ups(9, seed);
    doubtful += doubtful_power_up(values, constant_of(9)) ? 1 : 0;
    values[2].value += si(20.0, "deg/h");
    EXPECT_EQ(doubtful_power_up(values, constant_of(9)), 2u) << seed;
  }
  EXPECT_NEAR(doubtful, 50, 25);
}

// Means that agree by chance far within their own noise do not make the next one an outlier.
TEST(PowerUps, TheNoiseOfEachIsTheLeastScatter) {
  std::vector<PowerUpValue> values{
      {"a", 0.0, 1.0}, {"b", 1e-4, 1.0}, {"c", -1e-4, 1.0}, {"d", 0.0, 1.0}, {"e", 0.1, 1.0}};
  EXPECT_TRUE(found_in(values).empty());
  for (PowerUpValue& one : values) one.variance = 0.0;
  EXPECT_EQ(found_in(values).size(), 1u);
}

std::vector<double> noise_of_sample(std::size_t count) {
  std::vector<double> values(count);
  RandomStream(11).normal(0, values);
  return values;
}

TEST(LostByValue, IsSaidOfTheSideThatIsLost) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto high = noise_of_sample(20000), low = high, random = high;
  for (std::size_t i = 0; i < high.size(); ++i) {
    if (high[i] > 1.3) high[i] = nan;
    if (low[i] < -2.0) low[i] = nan;
    if (i % 9 == 0) random[i] = nan;
  }
  ASSERT_EQ(lost_by_value(high, "x").size(), 1u);
  EXPECT_EQ(lost_by_value(high, "x")[0].code, "large_values_lost");
  ASSERT_EQ(lost_by_value(low, "x").size(), 1u);
  EXPECT_EQ(lost_by_value(low, "x")[0].code, "small_values_lost");
  EXPECT_TRUE(lost_by_value(random, "x").empty());
}

EvenSignal signal_of(std::vector<double> values) {
  EvenSignal signal;
  signal.made = std::move(values);
  signal.values = signal.made;
  signal.rate = 1.0;
  return signal;
}

TEST(Zeros, AreNoValuesOfAFineOutputAndValuesOfACoarseOne) {
  auto fine = noise_of_sample(20000), coarse = fine, dead = fine, far = fine;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    coarse[i] = std::round(coarse[i]);
    if (std::abs(dead[i]) < 0.05) dead[i] = 0.0;
    far[i] = i % 100 == 0 ? 0.0 : far[i] + 50.0;
    if (i % 200 == 7) fine[i] = 0.0;
  }
  EvenSignal one = signal_of(fine), other = signal_of(far), steps = signal_of(coarse), band = signal_of(dead);
  EXPECT_EQ(take_zeros_out(one, "x").size(), 1u);
  EXPECT_TRUE(std::isnan(one.values[7]));
  EXPECT_EQ(take_zeros_out(other, "x").size(), 1u);
  EXPECT_TRUE(take_zeros_out(steps, "x").empty());
  EXPECT_TRUE(take_zeros_out(band, "x").empty());
}

TEST(Zeros, BetweenTheSamplesOfASlowerSensorAreRemoved) {
  for (const double mean : {0.0, 3.5, 6.0, 50.0}) {
    auto between = noise_of_sample(9000), band = between, rest = between;
    for (std::size_t i = 0; i < between.size(); ++i) {
      between[i] = i * 4 / 9 == (i + 1) * 4 / 9 ? 0.0 : between[i] + mean;
      if (std::abs(band[i]) < 1.0) band[i] = 0.0;
      rest[i] = i % 3 == 0 ? 30.0 * std::sin(1e-3 * static_cast<double>(i)) : 0.0;
      if (std::abs(rest[i]) < 20.0) rest[i] = 0.0;
    }
    EvenSignal one = signal_of(between), other = signal_of(band), motion = signal_of(rest);
    const Findings found = take_zeros_out(one, "x");
    ASSERT_EQ(found.size(), 1u) << mean;
    EXPECT_EQ(found[0].code, "zeros_between_samples");
    EXPECT_EQ(one.values.size(), 4000u);
    EXPECT_NEAR(one.rate, 4.0 / 9.0, 1e-12);
    EXPECT_TRUE(take_zeros_out(other, "x").empty());
    EXPECT_TRUE(take_zeros_out(motion, "x").empty());
  }
}

TEST(Repeats, OfASlowerSensorAreRemoved) {
  const auto values = noise_of_sample(4000);
  for (const std::size_t times : {1u, 2u, 7u, 8u}) {
    std::vector<double> held{values[0]};  // the record begins with the last sample of a value
    for (std::size_t i = 1; i < values.size(); ++i) held.insert(held.end(), times, values[i]);
    EvenSignal one = signal_of(held);
    const Findings found = take_repeats_out(one, "x");
    EXPECT_EQ(found.size(), times > 1 ? 1u : 0u) << times;
    EXPECT_NEAR(one.rate, 1.0 / static_cast<double>(times), 1e-12);
    if (times > 1) EXPECT_TRUE(std::ranges::equal(one.values.subspan(0, 100), std::span(values).subspan(1, 100)));
  }
  auto coarse = noise_of_sample(4000);
  for (double& value : coarse) value = std::round(value);
  EvenSignal steps = signal_of(coarse);
  EXPECT_TRUE(take_repeats_out(steps, "x").empty());
}

}  // namespace
}  // namespace tumble
