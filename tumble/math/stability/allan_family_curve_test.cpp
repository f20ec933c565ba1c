#include "tumble/math/stability/allan_family_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tumble/math/noise_model.hpp"

namespace tumble::allan_family_curve_test {
namespace {

constexpr Stability measures[] = {Stability::allan,
                                  Stability::overlapping_allan,
                                  Stability::modified_allan,
                                  Stability::time,
                                  Stability::hadamard,
                                  Stability::overlapping_hadamard,
                                  Stability::total,
                                  Stability::modified_total,
                                  Stability::time_total,
                                  Stability::hadamard_total,
                                  Stability::parabolic,
                                  Stability::theo1,
                                  Stability::theoh,
                                  Stability::peak_interval_error,
                                  Stability::rms_interval_error};

std::vector<double> white(std::size_t samples, std::uint64_t seed) {
  std::vector<double> rate(samples, 0.0);
  add_noise({.angle_random_walk = 1.0}, 2.0, RandomStream(seed), rate);
  return rate;
}

const std::vector<DeviationPoint> known_white{{.factor = 1, .tau = 0.5, .alpha = 0}};

TEST(StabilityCurve, IsTheMeasureItselfAtShortTau) {
  const auto rate = white(600, 4);
  for (const Stability measure : measures) {
    const auto curve = stability_curve(measure, rate, 2.0, {}, known_white);
    ASSERT_GT(curve.size(), 10u) << static_cast<int>(measure);
    for (const auto& point : curve) {
      const bool whole = point.factor < 32 || measure == Stability::theoh;  // 600 samples are below 4096
      if (!whole) continue;
      const std::size_t factors[1] = {point.factor};
      const auto direct = stability_of_rate(measure, rate, 0.5, factors, {.alpha = 0});
      ASSERT_EQ(direct.size(), 1u);
      EXPECT_NEAR(point.deviation / direct[0].deviation, 1.0, 1e-12) << static_cast<int>(measure) << point.factor;
      EXPECT_EQ(point.tau, direct[0].tau);
      EXPECT_EQ(point.edf, direct[0].edf);
    }
  }
}

// Blocks leave 16 and more terms to a tau. Neighbouring terms that are tau/16 apart correlate by 0.9 and more, so that
// what is left out changes a sum of squares of N/tau = 10 and more independent stretches by less than 2 %.
TEST(StabilityCurve, BlocksTakeFewerOfTheSameTerms) {
  const auto rate = white(4000, 5);
  for (const Stability measure : {Stability::modified_total, Stability::hadamard_total, Stability::theo1}) {
    std::size_t compared = 0;
    for (const auto& point : stability_curve(measure, rate, 2.0, {}, known_white)) {
      if (point.factor < 100 || point.factor > 400) continue;
      const std::size_t factors[1] = {point.factor};
      const auto direct = stability_of_rate(measure, rate, 0.5, factors, {.alpha = 0});
      ASSERT_EQ(direct.size(), 1u);
      // 4 sigma: over 150 such records the two differ by up to 0.11 of the standard uncertainty (rms).
      EXPECT_NEAR(point.deviation / direct[0].deviation, 1.0, 0.44 / std::sqrt(2.0 * point.edf))
          << static_cast<int>(measure) << point.factor;
      EXPECT_NEAR(point.tau, direct[0].tau, 1e-12);
      ++compared;
    }
    EXPECT_GE(compared, 5u);
  }
}

TEST(StabilityCurve, LongThinnedRecordsKeepTheWhiteSlope) {
  const auto rate = white(50000, 6);
  const auto curve = stability_curve(Stability::theoh, rate, 2.0, {}, known_white);
  ASSERT_GT(curve.back().factor, 30000u);  // the last tenth of a decade below three quarters of the record
  for (const auto& point : curve) {
    const double truth = 1.0 / std::sqrt(point.tau);
    // 99.99 % of the distribution that the limits say of 95 %.
    const auto limits = deviation_limits(point.deviation, point.edf, 0.9999);
    EXPECT_LT(limits.lower, truth) << point.tau;
    EXPECT_GT(limits.upper, truth) << point.tau;
  }
}

TEST(StabilityCurve, TakesTheNoiseTypeOfEachTau) {
  const std::vector<DeviationPoint> known{{.factor = 1, .tau = 0.5, .alpha = 0},
                                          {.factor = 8, .tau = 4.0, .alpha = -2}};
  for (const auto& point : stability_curve(Stability::overlapping_hadamard, white(600, 4), 2.0, {}, known))
    EXPECT_EQ(point.alpha, point.tau < 4.0 ? 0 : -2);
}

TEST(StabilityCurve, GapsLeaveOutWhatTheyCut) {
  auto rate = white(3000, 8);
  for (std::size_t i = 1400; i < 1600; ++i) rate[i] = std::numeric_limits<double>::quiet_NaN();
  for (const Stability measure : measures) {
    const auto curve = stability_curve(measure, rate, 2.0, {}, known_white);
    ASSERT_GT(curve.size(), 20u) << static_cast<int>(measure);
    for (const auto& point : curve) {
      EXPECT_TRUE(std::isfinite(point.upper)) << static_cast<int>(measure);
      EXPECT_LE(static_cast<double>(point.factor), 1401.0);
    }
  }
  for (std::size_t i = 0; i < rate.size(); i += 3) rate[i] = std::numeric_limits<double>::quiet_NaN();
  for (const Stability measure : measures)
    for (const auto& point : stability_curve(measure, rate, 2.0, {}, known_white))
      EXPECT_LE(point.factor, 2u) << static_cast<int>(measure);  // two samples between gaps
}

}  // namespace
}  // namespace tumble::allan_family_curve_test
