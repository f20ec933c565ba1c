#include "tumble/math/stability/allan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

std::vector<double> white_noise(std::size_t count, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<double> rate(count);
  for (auto& value : rate) value = normal(engine);
  return rate;
}

struct Direct {
  long double variance = 0.0L;
  std::size_t count = 0;
};

/// The definition, term by term, in long double. Sample rate 1 Hz.
Direct direct_sum(const std::vector<double>& rate, std::size_t m) {
  std::vector<long double> x(rate.size() + 1, 0.0L);
  std::vector<std::size_t> bad(rate.size() + 1, 0);
  for (std::size_t n = 0; n < rate.size(); ++n) {
    x[n + 1] = x[n] + (std::isnan(rate[n]) ? 0.0L : static_cast<long double>(rate[n]));
    bad[n + 1] = bad[n] + std::isnan(rate[n]);
  }
  Direct result;
  for (std::size_t n = 0; n + 2 * m < x.size(); ++n) {
    if (bad[n + 2 * m] != bad[n]) continue;
    const long double z = (x[n + 2 * m] - x[n + m]) - (x[n + m] - x[n]);
    result.variance += z * z;
    ++result.count;
  }
  result.variance /= 2.0L * m * m * result.count;
  return result;
}

void expect_equals_direct_sum(const std::vector<double>& rate) {
  for (const auto& point : overlapping_allan(rate, 1.0, {.longest_fraction = 0.5})) {
    const auto direct = direct_sum(rate, point.factor);
    EXPECT_EQ(point.count, direct.count);
    const double expected = static_cast<double>(std::sqrt(direct.variance));
    EXPECT_NEAR(point.deviation, expected, 1e-10 * expected) << "factor " << point.factor;
  }
}

TEST(OverlappingAllan, EqualsDirectSum) {
  expect_equals_direct_sum(white_noise(100000, 1));
  expect_equals_direct_sum(white_noise(7, 2));
}

TEST(OverlappingAllan, EqualsDirectSumBesideLargeMeanAndDrift) {
  auto rate = white_noise(200000, 3);
  for (std::size_t n = 0; n < rate.size(); ++n) rate[n] += 1e4 + 0.005 * static_cast<double>(n);
  expect_equals_direct_sum(rate);
}

TEST(OverlappingAllan, EqualsDirectSumOfTheTermsThatGapsLeave) {
  auto rate = white_noise(50000, 4);
  for (std::size_t n = 0; n < 40000; n += 700 + n / 50) rate[n] = missing;
  for (std::size_t n = 42000; n < 42010; ++n) rate[n] = missing;
  rate.front() = rate.back() = missing;
  expect_equals_direct_sum(rate);
}

TEST(OverlappingAllan, ScalesWithSignalAndIgnoresItsMean) {
  const auto rate = white_noise(5000, 5);
  auto other = rate;
  for (auto& value : other) value = 1e-6 * value + 3.0;
  const auto a = overlapping_allan(rate, 100.0, {});
  const auto b = overlapping_allan(other, 100.0, {});
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    // Rounding of 3 + 1e-6 z: 2.2e-16/1e-6 = 2e-10 of a sample, an independent one each.
    EXPECT_NEAR(b[i].deviation, 1e-6 * a[i].deviation, 1e-9 * 1e-6 * a[i].deviation);
    EXPECT_EQ(a[i].alpha, b[i].alpha);
    EXPECT_DOUBLE_EQ(a[i].edf, b[i].edf);
    EXPECT_DOUBLE_EQ(a[i].tau, static_cast<double>(a[i].factor) / 100.0);
    EXPECT_LT(a[i].lower, a[i].deviation);
    EXPECT_GT(a[i].upper, a[i].deviation);
  }
}

TEST(OverlappingAllan, WhiteNoiseFallsWithRootOfTau) {
  // Expected deviation 1/sqrt(m); relative sd of a deviation is 1/sqrt(2 edf), 4 of them allowed.
  for (const auto& point : overlapping_allan(white_noise(200000, 6), 1.0, {})) {
    if (point.edf < 50.0) continue;
    const double ratio = point.deviation * std::sqrt(static_cast<double>(point.factor));
    EXPECT_NEAR(ratio, 1.0, 4.0 / std::sqrt(2.0 * point.edf)) << point.factor;
    EXPECT_EQ(point.alpha, 0) << point.factor;
  }
}

TEST(OverlappingAllan, SurvivesConstantSignal) {
  for (const auto& point : overlapping_allan(std::vector<double>(1000, 9.8), 1.0, {})) {
    EXPECT_EQ(point.deviation, 0.0);
    EXPECT_EQ(point.upper, 0.0);
  }
}

TEST(OverlappingAllan, RefusesWhatItCannotUse) {
  const auto kind_of = [](const std::vector<double>& rate, double sample_rate, const AllanOptions& options) {
    try {
      overlapping_allan(rate, sample_rate, options);
    } catch (const Error& error) {
      return error.kind;
    }
    return Error::Kind::internal;
  };
  const auto rate = white_noise(100, 7);
  EXPECT_EQ(kind_of({}, 1.0, {}), Error::Kind::bad_data);
  EXPECT_EQ(kind_of({1.0, missing, 2.0}, 1.0, {}), Error::Kind::bad_data);
  EXPECT_EQ(kind_of({1.0, 2.0, 3.0, std::numeric_limits<double>::infinity()}, 1.0, {}), Error::Kind::bad_data);
  EXPECT_EQ(kind_of(rate, 0.0, {}), Error::Kind::bad_input);
  EXPECT_EQ(kind_of(rate, missing, {}), Error::Kind::bad_input);
  EXPECT_EQ(kind_of(rate, 1.0, {.points_per_decade = -1.0}), Error::Kind::bad_input);
  EXPECT_EQ(kind_of(rate, 1.0, {.confidence = 1.0}), Error::Kind::bad_input);
  EXPECT_EQ(kind_of(rate, 1.0, {.longest_fraction = 0.6}), Error::Kind::bad_input);
  EXPECT_EQ(kind_of(rate, 1.0, {.factors = {4, 1}}), Error::Kind::bad_input);
  EXPECT_EQ(kind_of(rate, 1.0, {.factors = {0, 1}}), Error::Kind::bad_input);
}

TEST(AveragingFactors, AreDistinctAndReachTheLongest) {
  EXPECT_EQ(averaging_factors(20, 0.0), (std::vector<std::size_t>{1, 2, 4, 8, 16}));
  EXPECT_EQ(averaging_factors(10, 10.0), (std::vector<std::size_t>{1, 2, 3, 4, 5, 6, 8, 10}));
  EXPECT_EQ(averaging_factors(1, 10.0), (std::vector<std::size_t>{1}));
}

TEST(OverlappingAllan, RefusesValuesWhoseSquaresOverflow) {
  std::vector<double> rate(100);
  for (std::size_t k = 0; k < rate.size(); ++k) rate[k] = (k % 3 == 0 ? 1.0 : -2.0) * 1e200;
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "too large to be squared"},
                      [&] { overlapping_allan(rate, 1.0, {}); }));
}

// The type at an averaging time, and with it the band, does not depend on which others are asked for.
TEST(OverlappingAllan, TheBandDoesNotDependOnWhatElseIsAskedFor) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto rate = white_noise(10000, seed);
    const auto alone = overlapping_allan(rate, 1.0, {.factors = {2000}});
    for (const std::vector<std::size_t>& others : {std::vector<std::size_t>{1, 2000}, {7, 300, 2000}, {1999, 2000}}) {
      const auto among = overlapping_allan(rate, 1.0, {.factors = others});
      EXPECT_EQ(among.back().alpha, alone[0].alpha) << seed;
      EXPECT_EQ(among.back().upper, alone[0].upper) << seed;
    }
    EXPECT_LT(alone[0].edf, 20.0) << seed;  // five averages of white noise, and not thousands of white phase noise
  }
}

}  // namespace
}  // namespace tumble
