#include "tumble/math/symmetric_factor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tumble {
namespace {

Matrix square(const Matrix& f) {
  Matrix out(f.rows, f.rows);
  for (std::size_t i = 0; i < f.rows; ++i)
    for (std::size_t j = 0; j < f.rows; ++j)
      for (std::size_t c = 0; c < f.columns; ++c) out(i, j) += f(i, c) * f(j, c);
  return out;
}

TEST(SymmetricFactor, SquareOfTheFactorIsTheMatrixWhateverTheUnits) {
  Matrix c(3, 3);
  c.values = {4.0, 1e-8, -0.5, 1e-8, 1e-16, 2e-9, -0.5, 2e-9, 1.0};
  const auto [factor, excess] = symmetric_factor(c);
  EXPECT_EQ(factor.columns, 3u);
  EXPECT_LT(excess, 1e-14);
  const Matrix again = square(factor);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)  // three products of size one, each rounded
      EXPECT_NEAR(again(i, j) / std::sqrt(c(i, i) * c(j, j)), c(i, j) / std::sqrt(c(i, i) * c(j, j)), 1e-14);
}

TEST(SymmetricFactor, RankOneIsOneColumn) {
  Matrix c(3, 3);
  const double v[] = {2.0, -3e-7, 0.0};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) c(i, j) = v[i] * v[j];
  const auto [factor, excess] = symmetric_factor(c);
  ASSERT_EQ(factor.columns, 1u);
  EXPECT_NEAR(factor(0, 0), 2.0, 1e-15);
  EXPECT_NEAR(factor(1, 0), -3e-7, 1e-21);
  EXPECT_EQ(factor(2, 0), 0.0);
}

TEST(SymmetricFactor, ExcessTellsWhatIsNotPositiveSemidefinite) {
  Matrix c(2, 2);
  c.values = {1.0, 1.1, 1.1, 1.0};  // eigenvalues 2.1 and -0.1; the rest after one column is 1 - 1.21
  EXPECT_NEAR(symmetric_factor(c).excess, 0.21, 1e-14);
  c.values = {0.0, 1.0, 1.0, 0.0};
  EXPECT_TRUE(std::isinf(symmetric_factor(c).excess));
}

TEST(SymmetricFactor, RoundingBelowTheScaleIsNoColumn) {
  Matrix c(2, 2);
  c.values = {1.0, 0.0, 0.0, -1e-17};
  EXPECT_LT(symmetric_factor(c, {1.0, 1.0}).excess, 1e-16);
  EXPECT_EQ(symmetric_factor(c, {1.0, 1.0}).factor.columns, 1u);
}

}  // namespace
}  // namespace tumble
