#include "tumble/math/allan_theoh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tumble/math/allan_family.hpp"
#include "tumble/math/noise_model.hpp"

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
TEST(Stability, TheoHLimitsHoldTheAllanDeviation) {
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

}  // namespace
}  // namespace tumble
