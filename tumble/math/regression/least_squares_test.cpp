#include "tumble/math/regression/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Matrix polynomial(std::size_t n, std::size_t columns) {
  Matrix x(n, columns);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < columns; ++k) x(i, k) = std::pow(static_cast<double>(i) / 10.0, static_cast<double>(k));
  return x;
}

TEST(LeastSquares, RecoversExactParametersToRounding) {
  const Matrix x = polynomial(20, 3);
  std::vector<double> y(20);
  for (std::size_t i = 0; i < 20; ++i) y[i] = 2.0 - 3.0 * x(i, 1) + 0.5 * x(i, 2);
  const auto fit = least_squares(x, y, {}, {});
  // Rounding of the observations (2^-53 of about 5) times a condition of about 30.
  EXPECT_NEAR(fit.parameters[0], 2.0, 2e-14);
  EXPECT_NEAR(fit.parameters[1], -3.0, 5e-14);
  EXPECT_NEAR(fit.parameters[2], 0.5, 5e-14);
  EXPECT_TRUE(fit.unobservable.empty());
}

TEST(LeastSquares, MeanHasTheTextbookVariance) {
  const Matrix x(5, 1, 1.0);
  const auto fit = least_squares(x, {1, 2, 3, 4, 5}, {}, {});
  EXPECT_DOUBLE_EQ(fit.parameters[0], 3.0);
  EXPECT_NEAR(fit.covariance(0, 0), 2.5 / 5.0, 1e-15);  // s^2 = 10/4
  EXPECT_DOUBLE_EQ(fit.degrees_of_freedom, 4.0);
  EXPECT_NEAR(fit.leverage[2], 0.2, 1e-15);
  // AICc by hand: N ln(RSS/N) + 2k + 2k(k+1)/(N-k-1), k = 2
  EXPECT_NEAR(fit.aicc, 5 * std::log(2.0) + 4.0 + 12.0 / 2.0, 1e-12);
}

TEST(LeastSquares, NamesWhatIsUnobservable) {
  // Three squares that sum to one beside a constant: the ten-term model's problem in a 1 g field.
  Matrix x(12, 4);
  for (std::size_t i = 0; i < 12; ++i) {
    const double a = 0.4 * static_cast<double>(i), b = 0.7 * static_cast<double>(i) + 0.3;
    x(i, 0) = 1.0;
    x(i, 1) = std::pow(std::cos(a) * std::cos(b), 2);
    x(i, 2) = std::pow(std::sin(a) * std::cos(b), 2);
    x(i, 3) = std::pow(std::sin(b), 2);
  }
  LeastSquaresOptions options;
  options.names = {"D_F", "D_II", "D_OO", "D_SS"};
  const auto fit = least_squares(x, std::vector<double>(12, 1.0), {}, options);
  ASSERT_EQ(fit.unobservable.size(), 1u);
  for (const auto& name : options.names) EXPECT_NE(fit.unobservable[0].in_words.find(name), std::string::npos);
  EXPECT_GT(fit.condition, 1e6);
}

TEST(LeastSquares, RandomEffectIsDrawnToItsPrior) {
  // One observation of variance 1 of a parameter with prior 0 +- 1: the mean lies half way, the variance is 1/2.
  Matrix x(1, 1, 1.0);
  LeastSquaresOptions options;
  options.prior_sd = {1.0};
  options.known_sigma = true;
  const auto fit = least_squares(x, {2.0}, {1.0}, options);
  EXPECT_DOUBLE_EQ(fit.parameters[0], 1.0);
  EXPECT_DOUBLE_EQ(fit.covariance(0, 0), 0.5);
}

TEST(LeastSquares, HuberWithstandsAnOutlier) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Matrix x(200, 1, 1.0);
  std::vector<double> y(200);
  for (auto& v : y) v = normal(random);
  for (std::size_t i = 0; i < 10; ++i) y[i] = 50.0;
  LeastSquaresOptions options;
  options.robust = true;
  const auto fit = least_squares(x, y, {}, options);
  // 5 % contamination on one side moves Huber's location by about 0.05 * 1.345/0.82 = 0.08 sd; 4 sigma of the mean on
  // top.
  EXPECT_LT(std::abs(fit.parameters[0]), 0.08 + 4.0 / std::sqrt(190.0 * 0.95));
  EXPECT_LT(fit.weights[0], 0.05);
}

TEST(LeastSquares, GeneralisedEqualsWeightedForADiagonal) {
  const Matrix x = polynomial(8, 2);
  const std::vector<double> y{1, 3, 2, 5, 4, 6, 8, 7};
  std::vector<double> weights(8);
  Matrix covariance(8, 8);
  for (std::size_t i = 0; i < 8; ++i) {
    weights[i] = 1.0 / (1.0 + static_cast<double>(i));
    covariance(i, i) = 1.0 + static_cast<double>(i);
  }
  const auto a = least_squares(x, y, weights, {});
  const auto b = generalised_least_squares(x, y, covariance, {});
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(a.parameters[k], b.parameters[k], 1e-13);
  EXPECT_NEAR(a.covariance(0, 1), b.covariance(0, 1), 1e-13);
}

TEST(LeastSquaresCoverage, IntervalsHoldTheTruth) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const Matrix x = polynomial(12, 2);
  int inside = 0;
  const int trials = 4000;
  for (int t = 0; t < trials; ++t) {
    std::vector<double> y(12);
    for (std::size_t i = 0; i < 12; ++i) y[i] = 1.0 + 2.0 * x(i, 1) + 0.3 * normal(random);
    const auto fit = least_squares(x, y, {}, {});
    const double half = student_quantile(0.975, fit.degrees_of_freedom) * std::sqrt(fit.covariance(1, 1));
    inside += std::abs(fit.parameters[1] - 2.0) <= half;
  }
  EXPECT_NEAR(inside / static_cast<double>(trials), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / trials));
}

TEST(LeastSquaresCoverage, RobustIntervalsHoldTheTruthToo) {
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal;
  const Matrix x = polynomial(60, 2);
  LeastSquaresOptions options;
  options.robust = true;
  int inside = 0;
  const int trials = 2000;
  for (int t = 0; t < trials; ++t) {
    std::vector<double> y(60);
    for (std::size_t i = 0; i < 60; ++i) y[i] = 1.0 + 2.0 * x(i, 1) + 0.3 * normal(random);
    const auto fit = least_squares(x, y, {}, options);
    const double half = student_quantile(0.975, fit.degrees_of_freedom) * std::sqrt(fit.covariance(1, 1));
    inside += std::abs(fit.parameters[1] - 2.0) <= half;
  }
  // Huber's variance is asymptotic: at N = 60 its own error is of the order 1/N, allowed for beside the 4 sigma.
  EXPECT_NEAR(inside / static_cast<double>(trials), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / trials) + 1.0 / 60.0);
}

TEST(LeastSquares, RefusesWhatItCannotUse) {
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"2", "3"}}, [&] {
    least_squares(polynomial(2, 3), {1, 2}, {}, {});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "not finite"}, [&] {
    least_squares(polynomial(3, 1), {1, std::nan(""), 2}, {}, {});
  }));
  Matrix not_definite(2, 2, 1.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "not positive definite"}, [&] {
    generalised_least_squares(polynomial(2, 1), {1, 2}, not_definite, {});
  }));
}

TEST(Quantiles, AgreeWithPublishedTables) {
  // Student's t and chi-square tables, as printed to 3 and 4 digits after the point.
  EXPECT_NEAR(student_quantile(0.975, 1), 12.706, 5e-4);
  EXPECT_NEAR(student_quantile(0.975, 10), 2.228, 5e-4);
  EXPECT_NEAR(student_quantile(0.975, std::numeric_limits<double>::infinity()), 1.959964, 1e-6);
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.05, 10), 3.940, 5e-4);
}

TEST(QuantilesCoverage, IntervalOfAStandardDeviationHoldsTheTruth) {
  std::mt19937_64 random(17);
  const int trials = 20000;
  for (const int nu : {2, 7, 50}) {
    std::chi_squared_distribution<double> chi_square(nu);
    int inside = 0;
    for (int t = 0; t < trials; ++t) {
      const double sd = std::sqrt(chi_square(random) / nu);
      inside += std::abs(sd - 1.0) <= student_quantile(0.975, nu) * uncertainty_of_sd(sd, nu);
    }
    EXPECT_NEAR(inside / static_cast<double>(trials), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / trials)) << nu;
  }
  EXPECT_NEAR(uncertainty_of_sd(1.0, 1e6), 1.0 / std::sqrt(2e6), 1e-6);
}

// sd^2 nu/sigma^2 is chi-square: for nu = 3 its quantiles are 0.215795 and 9.348404 (tables). Half of their last digit,
// 5e-7, is 1.2e-6 of the root of the smaller one: 9e-6 of the upper limit 7.46.
TEST(SdInterval, IsThatOfChiSquare) {
  const SdInterval interval = interval_of_sd(2.0, 3.0);
  EXPECT_NEAR(interval.lower, 2.0 * std::sqrt(3.0 / 9.348404), 1e-5);
  EXPECT_NEAR(interval.upper, 2.0 * std::sqrt(3.0 / 0.215795), 1e-5);
  EXPECT_EQ(interval_of_sd(2.0, std::numeric_limits<double>::infinity()).lower, 2.0);
}

// Two variances with 7 and 15 degrees of freedom, and with a known second one: 4000 draws, 4 sigma = 0.0138, and up to
// 0.02 more is what the limits are known to hold beyond 95 %.
TEST(SdInterval, HoldsTheRootOfADifferenceOfVariances) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double share : {0.1, 0.5, 2.0})
    for (const double part_freedom : {15.0, infinity}) {
      int inside = 0;
      constexpr int draws = 4000;
      for (int k = 0; k < draws; ++k) {
        const RandomStream random = RandomStream(400).split(static_cast<std::uint64_t>(k));
        double total = 0.0, part = std::isinf(part_freedom) ? share : 0.0;
        for (std::uint64_t i = 0; i < 7; ++i) total += (1.0 + share) / 7.0 * std::pow(random.normal(i), 2);
        for (std::uint64_t i = 0; i < 15 && !std::isinf(part_freedom); ++i)
          part += share / 15.0 * std::pow(random.normal(100 + i), 2);
        const SdInterval interval = interval_of_excess_sd(total, 7.0, part, part_freedom);
        EXPECT_GE(interval.lower, 0.0);
        inside += interval.lower <= 1.0 && 1.0 <= interval.upper;
      }
      EXPECT_GT(inside / 4000.0, 0.95 - 0.0138 - 0.005) << share << " " << part_freedom;
      EXPECT_LT(inside / 4000.0, 0.95 + 0.0138 + 0.02) << share << " " << part_freedom;
    }
}

}  // namespace
}  // namespace tumble
