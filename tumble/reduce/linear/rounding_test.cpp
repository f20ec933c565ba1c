#include "tumble/reduce/linear/rounding.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/random.hpp"

namespace tumble::linear {
namespace {

Matrix diagonal_of(double a, double b, double ab) {
  Matrix m(2, 2);
  m(0, 0) = a, m(1, 1) = b;
  m(0, 1) = m(1, 0) = ab;
  return m;
}

TEST(RoundingCovariance, NumbersThatNothingPlacesAreUniform) {
  const Matrix covariance = rounding_covariance({0.3, 7.1}, diagonal_of(25.0, 25.0, 0.0), 0.0);
  EXPECT_NEAR(covariance(0, 0), 1.0 / 12.0, 2e-4);
  EXPECT_NEAR(covariance(0, 1), 0.0, 1e-9);
}

// x of any size, and -x, 2 x: the errors of a sawtooth that jumps at halves go together by -1 and -1/4.
TEST(RoundingCovariance, EqualOppositeAndMultipleNumbersGoTogether) {
  constexpr double third_harmonics = 0.01;
  EXPECT_NEAR(rounding_covariance({40.2, 40.2}, diagonal_of(25.0, 25.0, 25.0), 0.0)(0, 1), 1.0 / 12.0, third_harmonics);
  EXPECT_NEAR(rounding_covariance({40.2, -40.2}, diagonal_of(25.0, 25.0, -25.0), 0.0)(0, 1), -1.0 / 12.0,
              third_harmonics);
  EXPECT_NEAR(rounding_covariance({40.2, 80.4}, diagonal_of(25.0, 100.0, 50.0), 0.0)(0, 1), -1.0 / 48.0,
              third_harmonics);
}

TEST(RoundingCovariance, IsThatOfDrawnNumbers) {
  const double places[] = {3.15, 9.35}, noise = 0.1, sd = 0.2;
  const RandomStream random(1);
  constexpr std::size_t draws = 20000, samples = 40;
  double squares = 0.0, products = 0.0;
  for (std::size_t i = 0; i < draws; ++i) {
    double error[2];
    const double common = sd * random.normal(i);
    for (std::size_t k = 0; k < 2; ++k) {
      const double x = places[k] + (k == 0 ? 1.0 : 3.0) * common;
      double sum = 0.0;
      for (std::size_t s = 0; s < samples; ++s)
        sum += std::round(x + noise * random.split("sample").normal((i * 2 + k) * samples + s));
      error[k] = sum / samples - x;
    }
    squares += error[0] * error[0] / draws;
    products += error[0] * error[1] / draws;
  }
  const Matrix covariance =
      rounding_covariance({places[0], places[1]}, diagonal_of(sd * sd, 9.0 * sd * sd, 3.0 * sd * sd), noise);
  EXPECT_NEAR(covariance(0, 0), squares, 1.5e-3);
  EXPECT_NEAR(covariance(0, 1), products, 1.5e-3);
}

}  // namespace
}  // namespace tumble::linear
