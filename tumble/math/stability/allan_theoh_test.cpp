#include "tumble/math/stability/allan_theoh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/stability/allan_family.hpp"

namespace tumble {
namespace {

std::vector<double> record(const NoiseModel& noise, std::size_t samples, std::uint64_t seed) {
  std::vector<double> rate(samples, 0.0);
  add_noise(noise, 1.0, RandomStream(seed), rate);
  return rate;
}

DeviationPoint one(Stability measure, const std::vector<double>& phase, std::size_t factor,
                   const StabilityOptions& options) {
  const std::size_t factors[1] = {factor};
  const auto points = stability(measure, phase, 1.0, factors, options);
  EXPECT_EQ(points.size(), 1u) << factor;
  return points.empty() ? DeviationPoint{} : points.front();
}

/// ThêoH: the Allan deviation up to a tenth of the record, beyond it Theo1 by the mean ratio of the two.
TEST(Stability, TheoHGoesOnWhereAllanEnds) {
  const auto phase = phase_from_rate(record({.angle_random_walk = 1.0}, 1000, 3), 1.0);
  const StabilityOptions white{.alpha = 0};
  EXPECT_EQ(one(Stability::theoh, phase, 100, white).deviation,
            one(Stability::overlapping_allan, phase, 100, white).deviation);
  double ratio = 0.0;
  const std::size_t n = 30;  // floor(1001/30 - 3)
  for (std::size_t i = 0; i <= n; ++i)
    ratio += std::pow(one(Stability::overlapping_allan, phase, 9 + 3 * i, white).deviation /
                          one(Stability::theo1, phase, 12 + 4 * i, white).deviation,
                      2) /
             static_cast<double>(n + 1);
  const auto far = one(Stability::theoh, phase, 750, white);
  EXPECT_EQ(far.tau, 750.0);
  EXPECT_NEAR(far.deviation, std::sqrt(ratio) * one(Stability::theo1, phase, 1000, white).deviation, 1e-12);
  const std::size_t none[] = {200};  // 3 does not divide it
  EXPECT_TRUE(stability(Stability::theoh, phase, 1.0, none, white).empty());
}

/// Limits to 4 sd of the binomial about what the simulated edf and chi-square promise, which its shape keeps to 3 %.
TEST(StabilityCoverage, TheoHLimitsHoldTheAllanDeviation) {
  constexpr int records = 150;
  const std::vector<std::size_t> factors{30, 60, 120, 180, 225};
  const struct {
    NoiseModel noise;
    int alpha;
    double variance, slope;  // at tau = 1, exponent
  } cases[] = {{{.angle_random_walk = 1.0}, 0, 1.0, -1.0},
               {{.bias_instability = 1.0}, -1, 0.441271, 0.0},
               {{.rate_random_walk = 1.0}, -2, 1.0 / 3.0, 1.0}};
  for (const auto& one_case : cases) {
    std::vector<int> held(factors.size(), 0);
    for (std::uint64_t seed = 0; seed < records; ++seed) {
      const auto rate = record(one_case.noise, 300, seed);
      const auto points =
          stability(Stability::theoh, phase_from_rate(rate, 1.0), 1.0, factors, {.alpha = one_case.alpha});
      ASSERT_EQ(points.size(), factors.size());
      for (std::size_t i = 0; i < factors.size(); ++i) {
        const double truth = std::sqrt(one_case.variance * std::pow(points[i].tau, one_case.slope));
        held[i] += points[i].lower <= truth && truth <= points[i].upper ? 1 : 0;
      }
    }
    for (const int count : held)
      EXPECT_NEAR(count, 0.95 * records, (0.03 + 4.0 * std::sqrt(0.95 * 0.05 / records)) * records);
  }
}

// 1/(H_h + 1/(2 h)), h = m/2, for white phase noise; flicker from the quadratic form of Theo1 over 301 points, to one
// unit of the last digit that it printed.
TEST(TheoH, RatioOfPhaseNoiseFallsAsItsFormSays) {
  for (const std::size_t m : {12u, 40u, 300u}) {
    double harmonic = 0.0;
    for (std::size_t k = 1; k <= m / 2; ++k) harmonic += 1.0 / static_cast<double>(k);
    EXPECT_NEAR(expected_allan_over_theo1(2, m), 1.0 / (harmonic + 1.0 / static_cast<double>(m)), 1e-12) << m;
  }
  EXPECT_NEAR(expected_allan_over_theo1(1, 12), 0.6204, 1e-4);
  EXPECT_NEAR(expected_allan_over_theo1(1, 80), 0.4022, 1e-4);
  EXPECT_NEAR(expected_allan_over_theo1(1, 300), 0.3183, 1e-4);
  EXPECT_EQ(theo_ratio_change(0, 301, 90), 1.0);
}

struct Spread {
  double mean = 0.0, error = 0.0;
};

/// ThêoH variance over the Allan variance.
Spread spread(const std::vector<double>& ratios) {
  double sum = 0.0, squares = 0.0;
  for (const double ratio : ratios) {
    sum += ratio;
    squares += ratio * ratio;
  }
  const double count = static_cast<double>(ratios.size()), mean = sum / count;
  return {mean, std::sqrt((squares / count - mean * mean) / count)};
}

// The definition alone would be 1.4 and 1.7 times too large at these tau.
TEST(TheoH, HasTheLevelOfWhitePhaseNoise) {
  constexpr int records = 150;
  for (const std::size_t m : {60u, 180u}) {
    std::vector<double> ratios;
    int held = 0;
    for (std::uint64_t seed = 0; seed < records; ++seed) {
      std::vector<double> phase(301);
      RandomStream(500 + seed).normal(0, phase);
      const auto point = one(Stability::theoh, phase, m, {.alpha = 2});
      const double truth = std::sqrt(3.0) / static_cast<double>(m);
      ratios.push_back(std::pow(point.deviation / truth, 2));
      held += point.lower <= truth && truth <= point.upper ? 1 : 0;
    }
    const Spread found = spread(ratios);
    EXPECT_NEAR(found.mean, 1.0, 4.0 * found.error) << m;
    EXPECT_NEAR(held, 0.95 * records, 4.0 * std::sqrt(0.95 * 0.05 * records)) << m;
  }
}

// 4000 records gave a bias of at most 3 % on 300 samples.
TEST(TheoH, BiasOfRateNoiseIsSmall) {
  for (const int times : {1, 2}) {
    for (const std::size_t m : {60u, 180u}) {
      std::vector<double> ratios;
      for (std::uint64_t seed = 0; seed < 400; ++seed) {
        const auto rate = record(
            times == 1 ? NoiseModel{.angle_random_walk = 1.0} : NoiseModel{.rate_random_walk = 1.0}, 300, 900 + seed);
        const double tau = static_cast<double>(m), truth = times == 1 ? 1.0 / tau : tau / 3.0;
        ratios.push_back(
            std::pow(one(Stability::theoh, phase_from_rate(rate, 1.0), m, {.alpha = 2 - 2 * times}).deviation, 2) /
            truth);
      }
      const Spread found = spread(ratios);
      EXPECT_NEAR(found.mean, 1.0, 4.0 * found.error + 0.03) << times << " " << m;
    }
  }
}

}  // namespace
}  // namespace tumble
