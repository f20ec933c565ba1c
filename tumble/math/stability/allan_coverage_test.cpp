// Do the stated limits hold the truth as often as they say, and is the edf what repetition shows?

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_edf.hpp"
#include "tumble/math/stability/allan_family.hpp"

namespace tumble::allan_coverage_test {
namespace {

constexpr int seeds = 500;
constexpr std::size_t samples = 2000;

std::vector<double> noise_of(const NoiseModel& model, int seed) {
  std::vector<double> rate(samples, 0.0);
  add_noise(model, 1.0, RandomStream(20250 + static_cast<std::uint64_t>(seed)), rate);
  return rate;
}

struct Tally {
  int inside = 0;
  double sum = 0.0, squares = 0.0, edf = 0.0;

  void add(double variance) {
    sum += variance;
    squares += variance * variance;
  }
  /// 2 mean^2/variance over the seeds.
  double empirical_edf() const {
    const double mean = sum / seeds;
    return 2.0 * mean * mean / (squares / seeds - mean * mean);
  }
};

/// Relative sd of the empirical edf: of a sample variance of chi-square numbers, whose excess kurtosis is 12/edf, and
/// of the squared mean.
double relative_sd(double edf) { return std::sqrt((2.0 + 12.0 / edf) / seeds + 8.0 / (edf * seeds)); }

struct Noise {
  const char* name;
  NoiseModel model;
  int alpha;
  std::size_t from;  ///< factor at which the simulated noise has become the power law
};

// The bank of Markov processes that stands for flicker noise departs from 1/f (by 1 % of the deviation) at the shortest
// tau.
const Noise kinds[] = {{"white", {.angle_random_walk = 0.3}, 0, 1},
                       {"flicker", {.bias_instability = 2.0}, -1, 4},
                       {"random walk", {.rate_random_walk = 1e-3}, -2, 1}};

TEST(AllanCoverage, LimitsHoldTheTruthAsOftenAsStated) {
  // 4 sigma of a binomial share of 500 at 0.95: 0.039. The type is identified, so limits may be wider than with the
  // true type known, where a redder one was taken: up to 1 is allowed.
  const double margin = 4.0 * std::sqrt(0.95 * 0.05 / seeds);
  for (const auto& [name, model, alpha, from] : kinds) {
    std::map<std::size_t, Tally> tallies;
    for (int seed = 0; seed < seeds; ++seed) {
      for (const auto& point : overlapping_allan(noise_of(model, seed), 1.0, {.points_per_decade = 0.0})) {
        const double truth = std::sqrt(expected_allan_variance(model, point.tau));
        tallies[point.factor].inside += point.lower <= truth && truth <= point.upper;
      }
    }
    for (const auto& [factor, tally] : tallies) {
      if (factor < from) continue;
      EXPECT_GT(tally.inside / static_cast<double>(seeds), 0.95 - margin) << name << " factor " << factor;
    }
  }
}

TEST(AllanCoverage, LimitsOfKnownNoiseAreNoWiderThanStated) {
  const double margin = 4.0 * std::sqrt(0.95 * 0.05 / seeds);
  for (const auto& [name, model, alpha, from] : kinds) {
    std::map<std::size_t, Tally> tallies;
    for (int seed = 0; seed < seeds; ++seed) {
      for (const auto& point : overlapping_allan(noise_of(model, seed), 1.0, {.points_per_decade = 0.0})) {
        auto& tally = tallies[point.factor];
        tally.edf = phase_difference_edf(alpha, PhaseDifference{}, point.factor, point.count);
        const auto limits = deviation_limits(point.deviation, tally.edf, 0.95);
        const double truth = std::sqrt(expected_allan_variance(model, point.tau));
        tally.inside += limits.lower <= truth && truth <= limits.upper;
        tally.add(point.deviation * point.deviation);
      }
    }
    for (const auto& [factor, tally] : tallies) {
      if (factor < from) continue;
      EXPECT_NEAR(tally.inside / static_cast<double>(seeds), 0.95, margin) << name << " factor " << factor;
      // The published approximations are good to a few percent; 10 % beside the statistical error.
      EXPECT_NEAR(tally.empirical_edf() / tally.edf, 1.0, 4.0 * relative_sd(tally.edf) + 0.1) << name << " " << factor;
    }
  }
}

TEST(AllanCoverage, EdfOfWhiteRateNoiseIsExactAtShortTau) {
  // z of sampled white rate noise: correlations -1/2 at m = 1; 1/4, -1/2, -1/4 at m = 2. edf = M/(1 + 2 sum rho^2) for
  // large M.
  EXPECT_NEAR(phase_difference_edf(0, PhaseDifference{}, 1, 1000000), 1e6 / 1.5, 10.0);
  EXPECT_NEAR(phase_difference_edf(0, PhaseDifference{}, 2, 1000000), 1e6 / 1.75, 10.0);
  // White phase noise: -2/3 and 1/6 at lags m and 2m.
  EXPECT_NEAR(phase_difference_edf(2, PhaseDifference{}, 1, 1000000), 1e6 / (1.0 + 2.0 * (4.0 / 9 + 1.0 / 36)), 10.0);
}

TEST(AllanCoverage, EdfOfTotalDeviationsAgreesWithRepetition) {
  const std::size_t factors[] = {2, 16, 64, 200};
  const NoiseModel white{.angle_random_walk = 1.0};
  for (const auto measure : {Stability::total, Stability::modified_total, Stability::hadamard_total}) {
    std::map<std::size_t, Tally> tallies;
    for (int seed = 0; seed < seeds; ++seed) {
      auto rate = noise_of(white, seed);
      rate.resize(1000);
      const auto phase = phase_from_rate(rate, 1.0);
      for (const auto& point : stability(measure, phase, 1.0, factors, {.alpha = 0})) {
        tallies[point.factor].add(point.deviation * point.deviation);
        tallies[point.factor].edf = point.edf;
      }
    }
    for (const auto& [factor, tally] : tallies) {
      // 10 % for the linear approximations; below m = 8 ours may only be on the safe side.
      const double ratio = tally.empirical_edf() / tally.edf;
      EXPECT_GT(ratio, 1.0 - 4.0 * relative_sd(tally.edf) - 0.1) << static_cast<int>(measure) << " " << factor;
      if (factor > 8) {
        EXPECT_LT(ratio, 1.0 + 4.0 * relative_sd(tally.edf) + 0.1) << static_cast<int>(measure) << " " << factor;
      }
    }
  }
}

}  // namespace
}  // namespace tumble::allan_coverage_test
