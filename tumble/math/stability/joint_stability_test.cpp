#include "tumble/math/stability/joint_stability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tumble/math/noise_model.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr std::size_t joint_samples = 1024;

std::vector<double> noise(const NoiseModel& model, std::uint64_t seed, const char* name) {
  std::vector<double> values(joint_samples, 0.0);
  add_noise(model, 1.0, RandomStream(seed).split(name), values);
  return values;
}

/// Share of 400 pairs of records of that correlation whose limits hold it, at m = 8 and 64.
void expect_limits_hold(const NoiseModel& model, double correlation) {
  constexpr int records = 400;
  const std::vector<std::size_t> factors{8, 64};
  int held[2] = {};
  for (std::uint64_t seed = 0; seed < records; ++seed) {
    auto a = noise(model, seed, "a"), b = noise(model, seed, "b");
    const auto common = noise(model, seed, "common");
    for (std::size_t i = 0; i < joint_samples; ++i) {
      a[i] = std::sqrt(1.0 - correlation) * a[i] + std::sqrt(correlation) * common[i];
      b[i] = -7.0 * (std::sqrt(1.0 - correlation) * b[i] + std::sqrt(correlation) * common[i]);
    }
    const auto points = allan_correlation(a, b, 1.0, factors, 0.95);
    ASSERT_EQ(points.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i)
      held[i] += points[i].lower <= -correlation && -correlation <= points[i].upper ? 1 : 0;
  }
  for (const int count : held) EXPECT_NEAR(count, 0.95 * records, 4.0 * std::sqrt(0.95 * 0.05 * records));
}

TEST(AllanCorrelationCoverage, LimitsHoldTheTruth) {
  expect_limits_hold({.angle_random_walk = 1.0}, 0.0);
  expect_limits_hold({.angle_random_walk = 1.0}, 0.5);
  expect_limits_hold({.rate_random_walk = 1.0}, 0.5);
}

TEST(AllanCorrelation, LeavesOutWhatOneOfThemMisses) {
  auto a = noise({.angle_random_walk = 1.0}, 1, "a"), b = a;
  for (std::size_t i = 0; i < joint_samples; ++i) b[i] = 3.0 * a[i] + 1.0;
  a[100] = b[200] = std::numeric_limits<double>::quiet_NaN();
  const auto points = allan_correlation(a, b, 1.0, std::vector<std::size_t>{1, 4}, 0.95);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_NEAR(points[0].correlation, 1.0, 1e-12);
  EXPECT_LT(points[0].chance, 1e-12);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "two signals of the same length"},
                      [&] { allan_correlation(a, std::span(b).first(9), 1.0, std::vector<std::size_t>{1}, 0.95); }));
}

TEST(AllanCorrelation, OfAllPairsIsThatOfEach) {
  std::vector<std::vector<double>> signals;
  for (const char* name : {"a", "b", "c", "d"}) signals.push_back(noise({.angle_random_walk = 1.0}, 8, name));
  for (std::size_t i = 0; i < joint_samples; ++i) signals[1][i] += signals[0][i];
  signals[2][50] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::span<const double>> spans(signals.begin(), signals.end());
  const std::vector<std::size_t> factors{1, 8};
  const auto pairs = allan_correlations(spans, 1.0, factors, 0.95);
  ASSERT_EQ(pairs.size(), 6u);
  EXPECT_EQ(pairs[3].a, 1u);
  EXPECT_EQ(pairs[3].b, 2u);
  for (const auto& pair : pairs) {
    const auto alone = allan_correlation(spans[pair.a], spans[pair.b], 1.0, factors, 0.95);
    ASSERT_EQ(pair.points.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(pair.points[i].correlation, alone[i].correlation) << pair.a << " " << pair.b;
      EXPECT_EQ(pair.points[i].edf, alone[i].edf);
    }
  }
}

struct Held {
  std::vector<int> counts;
  std::vector<double> mean;
};

/// Instruments of these white noises beside a common walk that is much larger, at m = `factor`.
Held hats(const std::vector<double>& noises, std::size_t factor, std::uint64_t records) {
  Held held{std::vector<int>(noises.size(), 0), std::vector<double>(noises.size(), 0.0)};
  for (std::uint64_t seed = 0; seed < records; ++seed) {
    const auto common = noise({.rate_random_walk = 30.0}, seed, "common");
    std::vector<std::vector<double>> signals;
    const char* names[] = {"a", "b", "c", "d"};
    for (std::size_t k = 0; k < noises.size(); ++k) {
      signals.push_back(noise({.angle_random_walk = noises[k]}, seed, names[k]));
      for (std::size_t i = 0; i < joint_samples; ++i) signals[k][i] += common[i];
    }
    const std::vector<std::span<const double>> spans(signals.begin(), signals.end());
    const auto points = three_cornered_hat(spans, 1.0, std::vector<std::size_t>{factor}, 0.95);
    for (std::size_t k = 0; k < noises.size(); ++k) {
      const double truth = noises[k] * noises[k] / static_cast<double>(factor);
      const auto& found = points.at(0).instruments[k];
      held.counts[k] += found.lower <= truth && truth <= found.upper ? 1 : 0;
      held.mean[k] += found.variance / truth / static_cast<double>(records);
    }
  }
  return held;
}

// Limits to 4 sd of the binomial; the mean to 4 sd of sqrt((A B + C^2)/(nu records)), A and B the variances of the two
// differences and C the instrument's own: nu 186 at m = 8 and 21 at m = 64.
TEST(ThreeCorneredHatCoverage, FindsEachInstrumentWithLimitsThatHold) {
  constexpr int records = 100;
  const double reach = 4.0 * std::sqrt(0.95 * 0.05 * records);
  for (const std::size_t factor : {8u, 64u}) {
    const auto alike = hats({1.0, 1.0, 1.0}, factor, records), apart = hats({0.3, 1.0, 3.0}, factor, records);
    const double nu = factor == 8 ? 186.0 : 20.0;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(alike.counts[k], 0.95 * records, reach) << factor << " " << k;
      EXPECT_NEAR(apart.counts[k], 0.95 * records, reach) << factor << " " << k;
      EXPECT_NEAR(alike.mean[k], 1.0, 4.0 * std::sqrt((2.0 * 2.0 + 1.0) / (nu * records))) << factor;
    }
  }
  const auto four = hats({0.5, 1.0, 1.0, 2.0}, 8, records);
  for (const int count : four.counts) EXPECT_NEAR(count, 0.95 * records, reach);
}

TEST(ThreeCorneredHat, RefusesWhatCarriesNoAnswer) {
  const auto a = noise({.angle_random_walk = 1.0}, 1, "a"), b = noise({.angle_random_walk = 1.0}, 1, "b");
  const std::vector<std::span<const double>> two{a, b}, same{a, a, b};
  const std::vector<std::size_t> factors{1};
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "three or more signals"},
                      [&] { three_cornered_hat(two, 1.0, factors, 0.95); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "the same signal"},
                      [&] { three_cornered_hat(same, 1.0, factors, 0.95); }));
}

}  // namespace
}  // namespace tumble
