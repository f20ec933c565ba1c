// Variances of what scatters, and the degrees of freedom of results that hold them.

#include "tumble/methods/accelerometer_four_position/components.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/methods/accelerometer_four_position/reduce.hpp"

namespace tumble {
namespace {

using namespace accelerometer_four_position;

// In a balanced design with known variance k the restricted likelihood has its top at SS/(n - p) - k.
TEST(FourPositions, RepeatabilityIsWhatTheRepeatsScatterByBeyondTheNoise) {
  const std::size_t n = 12;
  Matrix x(n, 4), known(n, n), one(n, n);
  std::vector<double> z(n);
  double squares = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    x(i, i % 4) = 1.0;
    known(i, i) = 0.5;
    one(i, i) = 1.0;
    z[i] = 3.0 * std::sin(7.0 * static_cast<double>(i));
  }
  for (std::size_t g = 0; g < 4; ++g) {
    const double mean = (z[g] + z[g + 4] + z[g + 8]) / 3.0;
    for (const std::size_t i : {g, g + 4, g + 8}) squares += (z[i] - mean) * (z[i] - mean);
  }
  const double expected = squares / 8.0 - 0.5;
  const auto found = components_of(x, z, known, {one});
  EXPECT_NEAR(found.variance[0], expected, 1e-6 * expected);
  EXPECT_NEAR(found.covariance(0, 0), 2.0 * std::pow(expected + 0.5, 2) / 8.0, 1e-5 * expected * expected);
  for (std::size_t i = 0; i < n; ++i) known(i, i) = 100.0;
  const auto none = components_of(x, z, known, {one});
  EXPECT_EQ(none.variance[0], 0.0);
  EXPECT_EQ(none.covariance(0, 0), 0.0);
}

// Three power-ups through four temperatures, a mean fitted: 11 contrasts, of which 2 show power-ups and 9 single cells.
// Where the power-ups agree, their mean square is pooled with that of the cells, of 11 degrees of freedom.
TEST(FourPositions, MeanSquaresArePooledWhereAVarianceIsZero) {
  const std::size_t n = 12;
  Matrix x(n, 1, 1.0), power_ups(n, n);
  std::vector<double> cells(n), z(n);
  double squares = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) power_ups(i, j) = i / 4 == j / 4;
    cells[i] = i % 4 < 2 ? 1.0 + 0.2 * static_cast<double>(i % 2) : -1.0 - 0.2 * static_cast<double>(i % 2);
    squares += cells[i] * cells[i];
    const std::size_t power_up = i / 4;
    z[i] = cells[i] + 5.0 * static_cast<double>(power_up);
  }
  const auto agree = components_of(x, cells, Matrix(n, n), {identity(n), power_ups});
  EXPECT_EQ(agree.variance[1], 0.0);
  EXPECT_NEAR(agree.variance[0], squares / 11.0, 1e-6);
  EXPECT_NEAR(agree.covariance(0, 0), 2.0 * square(squares / 11.0) / 11.0, 1e-5);
  EXPECT_EQ(agree.freedom[0], 11.0);
  const auto differ = components_of(x, z, Matrix(n, n), {identity(n), power_ups});
  EXPECT_NEAR(differ.variance[0], squares / 9.0, 1e-6);
  EXPECT_NEAR(differ.variance[1], 25.0 - squares / 9.0 / 4.0, 1e-4);  // that of 0, 5, 10 less the cells' share
  EXPECT_EQ(differ.freedom, (std::vector{9.0, 2.0}));
}

/// Of 4000 normal errors whose variance is `known` and an estimate of 1 - known with d degrees of freedom: the share
/// inside of 95 %.
double share_inside(double known, std::size_t d) {
  const RandomStream random = RandomStream(94).split(d);
  int inside = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    double mean_square = 0.0;
    for (std::size_t k = 0; k < d; ++k) mean_square += square(random.normal(i * 8 + k)) / static_cast<double>(d);
    mean_square *= 1.0 - known;
    Reduced reduced;
    reduced.covariance = Matrix(1, 1, known + mean_square);
    reduced.estimated = {{{Matrix(1, 1, 1.0)},
                          Matrix(1, 1, 2.0 * square(mean_square) / static_cast<double>(d)),
                          {static_cast<double>(d)}}};
    const double half = student_quantile(0.975, freedom_of(reduced, {1.0})) * std::sqrt(known + mean_square);
    inside += std::abs(random.normal(i * 8 + 7)) < half ? 1 : 0;
  }
  return inside / 4000.0;
}

// Without a known part it is Student's t. With one of 5, 15 and 50 % the integral over chi-square is 0.940, 0.945 and
// 0.966 for d = 1, 0.947, 0.949 and 0.959 for d = 2, 0.947, 0.948 and 0.954 for d = 3; by Welch and Satterthwaite's nu
// 0.872, 0.881 and 0.929 for d = 1.
TEST(FourPositionsCoverage, AVarianceThatIsKnownInPart) {
  const double four_sd = 4.0 * std::sqrt(0.95 * 0.05 / 4000.0);
  constexpr double exact[3][3] = {{0.940, 0.945, 0.966}, {0.947, 0.949, 0.959}, {0.947, 0.948, 0.954}};
  for (const std::size_t d : {1, 2, 3}) {
    EXPECT_NEAR(share_inside(0.0, d), 0.95, four_sd) << d;
    EXPECT_NEAR(share_inside(0.05, d), exact[d - 1][0], four_sd) << d;
    EXPECT_NEAR(share_inside(0.15, d), exact[d - 1][1], four_sd) << d;
    EXPECT_NEAR(share_inside(0.5, d), exact[d - 1][2], four_sd) << d;
  }
}

// b_0 of 0.1 with 20 degrees of freedom and b_1 of 10 with one; at T = 1e-4 the variance is that of b_0.
TEST(FourPositions, ABiasHasItsOwnFreedomNotThatOfItsLeastCoefficient) {
  Reduced reduced;
  reduced.covariance = diagonal(std::vector{0.01, 100.0});
  reduced.estimated = {{{diagonal(std::vector{1.0, 0.0}), diagonal(std::vector{0.0, 1.0})},
                        diagonal(std::vector{2.0 * square(0.01) / 20.0, 2.0 * square(100.0)}),
                        {20.0, 1.0}}};
  EXPECT_NEAR(freedom_of(reduced, {1.0, 0.0}), 20.0, 1e-9);
  EXPECT_NEAR(freedom_of(reduced, {0.0, 1.0}), 1.0, 1e-9);
  EXPECT_GT(freedom_of(reduced, {1.0, 1e-4}), 19.0);
}
}  // namespace
}  // namespace tumble
