#include "tumble/math/stability/allan_fit.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::vector<AllanObservation> observed(const std::vector<double>& rate) {
  std::vector<AllanObservation> all;
  for (const auto& point : overlapping_allan(rate, 1.0, {}))
    all.push_back({point.factor, point.deviation * point.deviation, point.count});
  return thinned(all);
}

std::vector<double> drawn(const NoiseModel& noise, std::size_t samples, std::uint64_t seed) {
  std::vector<double> rate(samples, 0.0);
  add_noise(noise, 1.0, RandomStream(seed), rate);
  return rate;
}

/// The truth of the same index as the fitted term, sampled once a second.
std::array<double, 4> truth_of(const NoiseModel& noise) {
  return {noise.quantization_noise, noise.angle_random_walk, noise.bias_instability, noise.rate_random_walk};
}

/// Over 200 records: every true term found and 95 % of the intervals hold it (4 sigma of a binomial: 0.95 -
/// 4 sqrt(0.95 0.05/200) = 0.888, and not all of them), terms that are not there mostly left out, and where left out
/// the limit holds (zero is below any limit, so that is asked of terms that are there). The mean error: a fit of n
/// records has a mean z of 0 +- 1/sqrt(n); the spread of each z grows as the root of a coefficient known to p % is
/// skewed, by a bias of p^2/8 of itself, p/4 of its sd: 0.05 for the 20 % here.
void expect_coverage(const NoiseModel& noise, std::size_t samples) {
  const int records = 200;
  const auto truth = truth_of(noise);
  std::array<int, 4> kept{}, inside{};
  std::array<double, 4> sum{};
  for (int record = 0; record < records; ++record) {
    const auto fit = fit_allan(observed(drawn(noise, samples, 40000 + record)), samples, {});
    for (std::size_t t = 0; t < 4; ++t) {
      const auto& term = fit.terms[t];
      if (!term.kept) continue;
      ++kept[t];
      const double value = std::sqrt(term.squared), sd = term.squared_sd / (2.0 * value);
      inside[t] += std::abs(value - truth[t]) <= student_quantile(0.975, term.degrees_of_freedom) * sd;
      sum[t] += (term.squared - truth[t] * truth[t]) / term.squared_sd / records;
    }
  }
  for (std::size_t t = 0; t < 4; ++t) {
    if (truth[t] == 0.0) {
      // significance 0.05, halved by asking each of two tests for it, plus 4 sigma
      EXPECT_LE(kept[t], 0.05 * records + 4.0 * std::sqrt(0.05 * 0.95 * records)) << "term " << t;
      continue;
    }
    EXPECT_GE(kept[t], 0.99 * records) << "term " << t;
    EXPECT_GE(inside[t], (0.95 - 0.0617) * records) << "term " << t;
    EXPECT_LE(inside[t], (0.95 + 0.0497) * records) << "term " << t;
    // A z of squared over its own estimated sd is skewed: its mean is that much (one third of the skewness, at most
    // sqrt(8/50)/3 = 0.13) below zero.
    EXPECT_NEAR(sum[t], 0.0, 4.0 / std::sqrt(records) + 0.13) << "term " << t;
  }
}

TEST(AllanFitCoverage, IntervalsHoldWhiteAndRandomWalk) {
  expect_coverage({.angle_random_walk = 1.0, .rate_random_walk = 0.006}, 30000);
}
TEST(AllanFitCoverage, IntervalsHoldWhiteFlickerAndRandomWalk) {
  expect_coverage({.angle_random_walk = 1.0, .bias_instability = 0.25, .rate_random_walk = 0.02}, 40000);
}
TEST(AllanFitCoverage, IntervalsHoldQuantizationAndFlicker) {
  expect_coverage({.quantization_noise = 3.0, .angle_random_walk = 1.0, .bias_instability = 0.3}, 40000);
}

TEST(AllanFit, CurveOfTheModelGivesTheModel) {
  // Exact expectations in: exact coefficients out, chi-square zero.
  const NoiseModel noise{2.0, 1.0, 0.3, 0.01};
  std::vector<AllanObservation> exact;
  for (const std::size_t m : averaging_factors(20000, 0.0))
    exact.push_back({m, expected_allan_variance(noise, static_cast<double>(m)), 0});
  const auto fit = fit_allan(exact, 80000, {});
  EXPECT_LT(fit.chi_square, 1e-12);
  EXPECT_EQ(fit.model_error, 0.0);
  for (std::size_t t = 0; t < 4; ++t) {
    ASSERT_TRUE(fit.terms[t].kept);
    EXPECT_NEAR(std::sqrt(fit.terms[t].squared) / truth_of(noise)[t], 1.0, 1e-6);
  }
}

TEST(AllanFitCoverage, LimitOfASkippedTermHolds) {
  // K = 0.0006 with N = 1 over 20 000 samples is too weak to be seen in most records; its 95 % limit must hold in 95 %
  // of those where it is left out or more (4 sigma: 0.95 - 4 sqrt(0.95 0.05/200) = 0.888).
  const NoiseModel noise{.angle_random_walk = 1.0, .rate_random_walk = 0.0006};
  int left_out = 0, held = 0;
  AllanFitOptions options;
  options.terms = {NoiseTerm::white, NoiseTerm::random_walk};
  for (int record = 0; record < 200; ++record) {
    const auto fit = fit_allan(observed(drawn(noise, 20000, 70000 + record)), 20000, options);
    if (fit.terms[1].kept) continue;
    ++left_out;
    held += std::sqrt(fit.terms[1].upper_limit) >= noise.rate_random_walk;
  }
  EXPECT_GT(left_out, 60);
  EXPECT_GE(held, 0.888 * left_out);
}

TEST(AllanFit, WhatTheTermsCannotFollowWidensTheIntervals) {
  // White noise and a vibration of the same size at 1/20 of the sampling rate.
  auto rate = drawn({.angle_random_walk = 1.0}, 40000, 5);
  const auto clean = fit_allan(observed(rate), 40000, {});
  for (std::size_t i = 0; i < rate.size(); ++i)
    rate[i] += std::sin(0.05 * 2.0 * 3.141592653589793 * static_cast<double>(i));
  const auto shaken = fit_allan(observed(rate), 40000, {});
  EXPECT_EQ(clean.model_error, 0.0);
  EXPECT_GT(shaken.model_error, 0.05);
  EXPECT_GT(shaken.terms[1].squared_sd, 3.0 * clean.terms[1].squared_sd);
  EXPECT_GT(shaken.model_error_variance[1], 0.5 * shaken.covariance(1, 1));
}

TEST(AllanFit, LongRecordGivesWhiteNoiseAsWellAsItsSamples) {
  // N and K of a tactical gyro at 400 Hz. The best that can be known of N is the mean square of the white samples
  // themselves, relative sd of the root sqrt(1/(2 n)); what another unbiased estimate differs from the best is not
  // correlated with it, so its variance is the difference of the two. Octaves lose a few percent.
  const std::size_t samples = 1000000;
  const double n = 1.888e-4 * 20.0, k = 2.557e-6 / 20.0, best = std::sqrt(0.5 / samples);
  AllanFitOptions options;
  options.terms = {NoiseTerm::white, NoiseTerm::random_walk};
  for (const std::uint64_t seed : {9001, 9002, 9003}) {
    double squares = 0.0;
    for (const double value : drawn({.angle_random_walk = n}, samples, seed)) squares += value * value / samples;
    const auto fit =
        fit_allan(observed(drawn({.angle_random_walk = n, .rate_random_walk = k}, samples, seed)), samples, options);
    const auto& white = fit.terms[0];
    const double loss = 0.5 * white.squared_sd / white.squared / best;
    EXPECT_GT(loss, 1.0);
    EXPECT_LT(loss, 1.05);
    EXPECT_NEAR((std::sqrt(white.squared) - std::sqrt(squares)) / (n * best), 0.0, 4.0 * std::sqrt(loss * loss - 1.0));
  }
}

TEST(AllanFit, WeightsOfAWrongModelDoNotEndTheFit) {
  // Random walk alone, tried on what is mostly white noise, once left no positive coefficient for its own weights.
  const std::size_t samples = 200000;
  AllanFitOptions options;
  options.terms = {NoiseTerm::white, NoiseTerm::random_walk};
  const NoiseModel noise{.angle_random_walk = 1.888e-4 * 20.0, .rate_random_walk = 2.557e-6 / 20.0};
  const auto fit = fit_allan(observed(drawn(noise, samples, 9136)), samples, options);
  EXPECT_TRUE(fit.terms[0].kept);
}

TEST(AllanFit, RefusesWhatItCannotFit) {
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "fewer than 2 averaging times"}, [&] {
    fit_allan({{1, 1.0, 0}}, 100, {});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "not above zero"}, [&] {
    fit_allan({{1, 1.0, 0}, {2, 0.0, 0}}, 100, {});
  }));
}

TEST(AllanFit, RootIntervalHoldsAChiSquareVariance) {
  // One variance with nu degrees of freedom: sd of the root is root/sqrt(2 nu). 20000 draws: 4 sigma are 0.006; the
  // Wilson-Hilferty nodes add 0.002.
  const RandomStream random(12);
  for (const std::size_t nu : {4u, 10u, 40u}) {
    const double t = student_quantile(0.975, root_interval_degrees_of_freedom(static_cast<double>(nu), 1.0));
    int inside = 0;
    const int draws = 20000;
    for (int i = 0; i < draws; ++i) {
      double squares = 0.0;
      for (std::size_t k = 0; k < nu; ++k) squares += std::pow(random.split(nu).normal(i * nu + k), 2);
      const double root = std::sqrt(squares / static_cast<double>(nu));
      inside += std::abs(root - 1.0) <= t * root / std::sqrt(2.0 * static_cast<double>(nu));
    }
    EXPECT_NEAR(inside / static_cast<double>(draws), 0.95, 0.008) << nu;
  }
}

TEST(AllanFit, ThinsToOctavesAndKeepsTheEnds) {
  std::vector<AllanObservation> all;
  for (const std::size_t m : averaging_factors(1000, 10.0)) all.push_back({m, 1.0, 0});
  const auto few = thinned(all);
  EXPECT_EQ(few.front().factor, 1u);
  EXPECT_EQ(few.back().factor, all.back().factor);
  for (std::size_t i = 2; i < few.size(); ++i)
    EXPECT_GE(static_cast<double>(few[i].factor), 1.9 * static_cast<double>(few[i - 1].factor));
}

}  // namespace
}  // namespace tumble
