#include "tumble/math/linear_algebra.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <utility>

namespace tumble {
namespace {

using Vector = std::vector<double>;

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Elements uniform in [-1, 1].
Matrix random_matrix(std::size_t rows, std::size_t columns, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  Matrix out(rows, columns);
  for (double& value : out.values) value = draw(engine);
  return out;
}

/// Symmetric with eigenvalues between 1 and 1 + n, since those of A' A sum to |A|^2 <= n^2.
Matrix positive(std::size_t n, unsigned seed) {
  const Matrix a = random_matrix(n, n, seed);
  return 1.0 / static_cast<double>(n) * gram(a) + identity(n);
}

double greatest(const Matrix& a) {
  double out = 0.0;
  for (const double value : a.values) out = std::max(out, std::abs(value));
  return out;
}

bool is_symmetric(const Matrix& a) { return a.values == transposed(a).values; }

bool all_finite(const Matrix& a) {
  return std::ranges::all_of(a.values, [](double v) { return std::isfinite(v); });
}

Matrix of_rows(const std::vector<Vector>& rows) {
  Matrix out(rows.size(), rows.front().size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j) out(i, j) = rows[i][j];
  return out;
}

const Matrix small = of_rows({{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}});

// ---- vectors and parts: small integers, without rounding ---------------------------------------------------------

TEST(LinearAlgebra, VectorsAreSummedAndScaled) {
  const Vector a{3.0, -4.0}, b{1.0, 2.0};
  EXPECT_EQ(dot(a, b), -5.0);
  EXPECT_EQ(norm(a), 5.0);
  EXPECT_EQ(norm(Vector{}), 0.0);
  EXPECT_EQ(difference(a, b), (Vector{2.0, -6.0}));
  EXPECT_EQ(scaled_sum(a, 2.0, b), (Vector{5.0, 0.0}));
  EXPECT_EQ(scaled(-2.0, a), (Vector{-6.0, 8.0}));
  EXPECT_EQ(scaled(a, b), (Vector{3.0, -8.0}));
  EXPECT_EQ(inverses(Vector{4.0, 0.0}, 0.5), (Vector{0.25, 2.0}));
}

TEST(LinearAlgebra, PartsAreWhereTheIndicesSay) {
  EXPECT_EQ(row(small, 1), (Vector{4.0, 5.0, 6.0}));
  EXPECT_EQ(Vector(column(small, 2).begin(), column(small, 2).end()), (Vector{3.0, 6.0}));
  EXPECT_EQ(block(small, 0, 2, 1, 2).values, (Vector{2.0, 5.0, 3.0, 6.0}));
  EXPECT_EQ(chosen_columns(small, std::vector<std::size_t>{2, 0}).values, (Vector{3.0, 6.0, 1.0, 4.0}));
  EXPECT_EQ(row(chosen_rows(small, std::vector<std::size_t>{1, 1, 0}), 1), row(small, 1));
  EXPECT_EQ(transposed(small)(2, 1), 6.0);
  EXPECT_EQ(diagonal_of(small), (Vector{1.0, 5.0}));
  EXPECT_EQ(trace(diagonal(Vector{1.0, 5.0})), 6.0);
  EXPECT_EQ(column_norms(of_rows({{3.0, 0.0}, {4.0, 0.0}})), (Vector{5.0, 0.0}));
  Matrix a(2, 3);
  set_block(a, 0, 1, block(small, 0, 2, 1, 2));
  column(a, 0)[1] = 4.0;
  EXPECT_EQ(a.values, (Vector{0.0, 4.0, 2.0, 5.0, 3.0, 6.0}));
}

TEST(LinearAlgebra, BlocksAreJoinedToTheWhole) {
  const Matrix a = random_matrix(5, 4, 1);
  EXPECT_EQ(stacked(block(a, 0, 2, 0, 4), block(a, 2, 3, 0, 4)).values, a.values);
  EXPECT_EQ(beside(block(a, 0, 5, 0, 1), block(a, 0, 5, 1, 3)).values, a.values);
  EXPECT_EQ(stacked({}, a).values, a.values);
  EXPECT_EQ(beside(a, {}).values, a.values);
  EXPECT_EQ(stacked(Matrix(0, 4), a).rows, 5u);
}

// ---- products ----------------------------------------------------------------------------------------------------

TEST(LinearAlgebra, ProductsOfIntegersAreExact) {
  EXPECT_EQ((small * transposed(small)).values, (Vector{14.0, 32.0, 32.0, 77.0}));
  EXPECT_EQ(small * Vector({1.0, 0.0, -1.0}), (Vector{-2.0, -2.0}));
  EXPECT_EQ(transposed_product(small, Vector{1.0, -1.0}), (Vector{-3.0, -3.0, -3.0}));
  EXPECT_EQ(transposed_product(small, small).values, (transposed(small) * small).values);
  EXPECT_EQ(outer(Vector{1.0, 2.0}, Vector{3.0, 4.0}).values, (Vector{3.0, 6.0, 4.0, 8.0}));
  EXPECT_EQ((small + small - 2.0 * small).values, Vector(6, 0.0));
  EXPECT_EQ(scaled_rows(Vector{1.0, 2.0}, small).values, (diagonal(Vector{1.0, 2.0}) * small).values);
  const Vector w{1.0, 2.0, -3.0};
  EXPECT_EQ(scaled_columns(small, w).values, (small * diagonal(w)).values);
  EXPECT_EQ(sandwich(small, w).values, (small * diagonal(w) * transposed(small)).values);
  EXPECT_EQ(sandwich(small, diagonal(w)).values, sandwich(small, w).values);
  EXPECT_EQ(quadratic_form(w, diagonal(w)), 1.0 + 8.0 - 27.0);
  Matrix squares(3, 3);
  add_square(squares, 2.0, w);
  EXPECT_EQ(squares.values, (2.0 * outer(w, w)).values);
}

TEST(LinearAlgebra, LargeProductIsAssociative) {
  const Matrix a = random_matrix(40, 50, 2), b = random_matrix(50, 30, 3), c = random_matrix(30, 20, 4);
  // each element: sums of 50 and 30 products of elements up to 1, every one rounded; at worst 80 eps times 1500
  EXPECT_LT(greatest((a * b) * c - a * (b * c)), 80.0 * eps * 1500.0);
  EXPECT_GT(greatest((a * b) * c), 1.0);
}

TEST(LinearAlgebra, CovariancesAreSymmetricToTheLastBit) {
  const Matrix g = random_matrix(7, 12, 5), v = positive(12, 6);
  const Vector w = diagonal_of(v);
  EXPECT_TRUE(is_symmetric(sandwich(g, v)));
  EXPECT_TRUE(is_symmetric(sandwich(g, w)));
  EXPECT_TRUE(is_symmetric(gram(g)));
  EXPECT_TRUE(is_symmetric(gram(transposed(g), w)));
  EXPECT_TRUE(is_symmetric(inverse_symmetric(v)));
}

TEST(LinearAlgebra, NormalEquationsHoldTheWeights) {
  const Matrix a = of_rows({{1.0, 0.0}, {1.0, 1.0}, {1.0, 2.0}});
  const auto normal = normal_equations(a, Vector{1.0, 2.0, 4.0}, Vector{1.0, 3.0, 5.0});  // y = 1 + 2 t
  EXPECT_EQ(normal.matrix.values, (Vector{7.0, 10.0, 10.0, 18.0}));
  EXPECT_EQ(normal.right, (Vector{27.0, 46.0}));
  const auto x = solve_symmetric(normal.matrix, normal.right);
  EXPECT_NEAR(x[0], 1.0, 100.0 * eps);  // condition 23: 2 x 23 eps, times the size
  EXPECT_NEAR(x[1], 2.0, 100.0 * eps);
}

TEST(LinearAlgebra, EmptyMatricesGiveEmptyResults) {
  const Matrix none(0, 3);
  EXPECT_EQ(transposed(none).rows, 3u);
  EXPECT_EQ(gram(none).values, Vector(9, 0.0));
  EXPECT_EQ((transposed(none) * none).values, Vector(9, 0.0));
  EXPECT_EQ((none * Vector{1.0, 2.0, 3.0}).size(), 0u);
  EXPECT_TRUE(cholesky({}).positive);
  EXPECT_EQ(determinant({}), 1.0);
  EXPECT_TRUE(eigen_symmetric({}).values.empty());
  EXPECT_TRUE(inverse({}).empty());
  EXPECT_TRUE(solve(Matrix(), Vector{}).empty());
  EXPECT_TRUE(singular_values(none).empty());
  EXPECT_EQ(svd(none).v.values, identity(3).values);
  EXPECT_EQ(pseudo_inverse(none).rows, 3u);
  EXPECT_EQ(qr_fit(none, Vector{}).x, Vector(3, 0.0));
}

TEST(LinearAlgebra, OneByOneIsANumber) {
  const Matrix four(1, 1, 4.0);
  const Vector eight{8.0};
  EXPECT_EQ(solve(four, eight), Vector{2.0});
  EXPECT_EQ(solve_symmetric(four, eight), Vector{2.0});
  EXPECT_EQ(solve(cholesky(four), eight), Vector{2.0});
  EXPECT_EQ(cholesky(four).lower.values, Vector{2.0});
  EXPECT_EQ(inverse(four).values, Vector{0.25});
  EXPECT_EQ(inverse_symmetric(four).values, Vector{0.25});
  EXPECT_EQ(determinant(four), 4.0);
  EXPECT_EQ(singular_values(Matrix(1, 1, -4.0)), Vector{4.0});
  EXPECT_EQ(eigenvalues_symmetric(Matrix(1, 1, -4.0)), Vector{-4.0});
  EXPECT_EQ(condition(four), 1.0);
}

// ---- symmetric matrices ------------------------------------------------------------------------------------------

TEST(LinearAlgebra, SymmetricSystemsAreSolved) {
  const std::size_t n = 9;
  const Matrix a = positive(n, 7), x = random_matrix(n, 2, 8);  // condition below 1 + n = 10
  const double bound = 10.0 * 10.0 * eps * n;                   // n eps times the condition, times a sum of n
  EXPECT_LT(greatest(solve_symmetric(a, a * x) - x), bound);
  EXPECT_LT(greatest(solve(cholesky(a), a * x) - x), bound);
  EXPECT_LT(greatest(inverse_symmetric(a) * a - identity(n)), bound);
  const auto one = column(x, 1);
  EXPECT_LT(norm(difference(solve(cholesky(a), a * one), one)), bound);
  EXPECT_LT(norm(difference(solve_symmetric(a, a * one), one)), bound);
}

TEST(LinearAlgebra, OnlyTheLowerTriangleIsRead) {
  Matrix a = positive(4, 9);
  const Matrix b = random_matrix(4, 1, 10), before = solve_symmetric(a, b), lower = cholesky(a).lower;
  const auto values = eigenvalues_symmetric(a);
  a(0, 3) = 1e6;
  EXPECT_EQ(solve_symmetric(a, b).values, before.values);
  EXPECT_EQ(cholesky(a).lower.values, lower.values);
  EXPECT_EQ(eigenvalues_symmetric(a), values);
}

TEST(LinearAlgebra, CholeskyFactorGivesBackTheMatrix) {
  const std::size_t n = 40;  // beyond the size of one block
  const Matrix a = positive(n, 11);
  const auto factor = cholesky(a);
  ASSERT_TRUE(factor.positive);
  EXPECT_LT(greatest(factor.lower * transposed(factor.lower) - a), (n + 1) * eps * greatest(a));
  EXPECT_EQ(factor.lower(0, 1), 0.0);
  // the sum of the logarithms of eigenvalues above 1, each to n eps times the greatest
  double sum = 0.0;
  for (const double value : eigenvalues_symmetric(a)) sum += std::log(value);
  EXPECT_NEAR(factor.log_determinant, sum, n * n * eps * (1.0 + n));
}

TEST(LinearAlgebra, CholeskyRefusesWhatIsNotPositive) {
  for (const Matrix& a : {of_rows({{1.0, 2.0}, {2.0, 1.0}}), Matrix(2, 2), Matrix(2, 2, std::nan(""))}) {
    const auto factor = cholesky(a);
    EXPECT_FALSE(factor.positive);
    EXPECT_TRUE(factor.lower.empty());
    EXPECT_TRUE(std::isnan(factor.log_determinant));
  }
}

TEST(LinearAlgebra, WhiteningMakesTheCovarianceTheIdentity) {
  const std::size_t n = 6;
  const Matrix v = positive(n, 12), lower = cholesky(v).lower;
  const double bound = 10.0 * 7.0 * eps * n;  // n eps times the condition of v, times a sum of n
  EXPECT_LT(greatest(solve_lower(lower, transposed(solve_lower(lower, v))) - identity(n)), bound);
  const Matrix b = random_matrix(n, 3, 13);
  EXPECT_LT(greatest(transposed(lower) * solve_lower_transposed(lower, b) - b), bound);
  EXPECT_LT(greatest(transposed(lower) * solve_upper(transposed(lower), b) - b), bound);
  const auto one = column(b, 0);
  EXPECT_LT(norm(difference(lower * solve_lower(lower, one), one)), bound);
  EXPECT_EQ(solve_lower_transposed(lower, one), block(solve_lower_transposed(lower, b), 0, n, 0, 1).values);
}

TEST(LinearAlgebra, SemidefiniteSystemIsSolvedWhereItHasASolution) {
  const Matrix a = of_rows({{4.0, 2.0}, {2.0, 1.0}});  // rank 1; L = [1; 1/2], D = [4; 0] without rounding
  const auto x = solve_symmetric(a, Vector{8.0, 4.0});
  EXPECT_EQ(a * x, (Vector{8.0, 4.0}));
}

TEST(LinearAlgebra, EigenvectorsDiagonalise) {
  const std::size_t n = 8;
  const Matrix a = positive(n, 14);
  const auto [values, vectors] = eigen_symmetric(a);
  EXPECT_TRUE(std::ranges::is_sorted(values));
  EXPECT_GE(values.front(), 1.0 - n * eps * values.back());
  EXPECT_LT(greatest(a * vectors - scaled_columns(vectors, values)), 2.0 * n * eps * values.back());
  EXPECT_LT(greatest(gram(vectors) - identity(n)), 2.0 * n * eps);
  const auto alone = eigenvalues_symmetric(a);
  for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR(alone[k], values[k], 2.0 * n * eps * values.back());
}

// ---- general systems ---------------------------------------------------------------------------------------------

TEST(LinearAlgebra, SquareSystemsAreSolved) {
  const Matrix a = random_matrix(12, 12, 15), x = random_matrix(12, 2, 16);
  const double bound = 12.0 * 12.0 * eps * condition(a);
  EXPECT_LT(greatest(solve(a, a * x) - x), bound);
  EXPECT_LT(greatest(inverse(a) * a - identity(12)), bound);
  const auto one = column(x, 0);
  EXPECT_LT(norm(difference(solve(a, a * one), one)), bound);
  double product = 1.0;
  for (const double value : singular_values(a)) product *= value;
  EXPECT_NEAR(std::abs(determinant(a)) / product, 1.0, bound);
}

TEST(LinearAlgebra, DeterminantHasTheSignOfThePermutation) {
  EXPECT_EQ(determinant(of_rows({{0.0, 1.0}, {1.0, 0.0}})), -1.0);
  EXPECT_EQ(determinant(of_rows({{1.0, 2.0}, {2.0, 4.0}})), 0.0);
}

TEST(LinearAlgebra, InverseOfASingularMatrixIsNotFinite) {
  const Matrix a = of_rows({{1.0, 2.0}, {2.0, 4.0}});
  EXPECT_FALSE(all_finite(inverse(a)));
  EXPECT_FALSE(all_finite(solve(a, identity(2))));
}

TEST(LinearAlgebra, LeastSquaresLeaveAResidualAcrossTheColumns) {
  const Matrix a = random_matrix(20, 5, 17), b = random_matrix(20, 1, 18);
  const double bound = 20.0 * 20.0 * eps * condition(a);
  const auto x = solve(a, column(b, 0));
  const auto residual = difference(column(b, 0), a * x);
  EXPECT_LT(norm(transposed_product(a, residual)), bound);
  const auto fit = qr_fit(a, column(b, 0));
  const auto qr = householder_qr(a);
  EXPECT_LT(norm(difference(fit.x, x)), bound);
  EXPECT_LT(norm(difference(solve(qr, column(b, 0)), x)), bound);
  EXPECT_NEAR(fit.residual_square, dot(residual, residual), bound);
  EXPECT_EQ(fit.rank, 5u);
  EXPECT_LT(greatest(fit.root * transposed(fit.root) * gram(a) - identity(5)), 20.0 * bound * condition(a));
}

TEST(LinearAlgebra, FitOfLowerRankLeavesDependentColumnsAtZero) {
  Matrix a = random_matrix(10, 3, 19);
  std::ranges::copy(scaled(0.5, column(a, 0)), column(a, 2).begin());  // exactly half: the shorter one is dependent
  const Vector truth{2.0, -1.0, 0.0};
  const auto fit = qr_fit(a, a * truth);
  EXPECT_EQ(fit.rank, 2u);
  EXPECT_EQ(fit.root.columns, 2u);
  EXPECT_LT(norm(difference(fit.x, truth)), 100.0 * eps * condition(block(a, 0, 10, 0, 2)));
  EXPECT_EQ(row(fit.root, 2), (Vector{0.0, 0.0}));
  EXPECT_EQ(solve(a, a * truth)[2], 0.0);
}

TEST(LinearAlgebra, WideFitMeetsTheObservations) {
  const Matrix a = random_matrix(3, 7, 20);
  const Vector b{1.0, -2.0, 3.0};
  const auto fit = qr_fit(a, b);
  EXPECT_EQ(fit.rank, 3u);
  EXPECT_LT(norm(difference(a * fit.x, b)), 100.0 * eps * norm(fit.x));
}

TEST(LinearAlgebra, HouseholderFactorsGiveBackTheMatrix) {
  for (const auto& [rows, columns] : {std::pair<std::size_t, std::size_t>{9, 4}, {4, 9}, {70, 60}}) {
    const Matrix a = random_matrix(rows, columns, 21);
    const auto qr = householder_qr(a);
    const std::size_t k = std::min(rows, columns);
    const Matrix upper = upper_of(qr), padded = stacked(upper, Matrix(rows - k, columns));
    const double bound = 4.0 * static_cast<double>(rows * columns) * eps;  // Higham, theorem 19.4: n m eps |a|
    EXPECT_LT(greatest(q_product(qr, padded) - a), bound);
    EXPECT_LT(greatest(q_transposed_product(qr, a) - padded), bound);
    EXPECT_LT(greatest(gram(q_product(qr, identity(rows))) - identity(rows)), bound);
    EXPECT_EQ(upper(k - 1, 0), 0.0);
    EXPECT_EQ(q_transposed_product(qr, column(a, 1)).size(), rows);
  }
}

TEST(LinearAlgebra, LastColumnsOfQAreOrthogonalToTheMatrix) {
  const Matrix a = random_matrix(8, 3, 22);
  const Matrix rest = q_product(householder_qr(a), block(identity(8), 0, 8, 3, 5));
  EXPECT_LT(greatest(transposed_product(a, rest)), 4.0 * 8.0 * 3.0 * eps);
  EXPECT_LT(greatest(gram(rest) - identity(5)), 4.0 * 8.0 * 3.0 * eps);
}

// ---- singular values ---------------------------------------------------------------------------------------------

TEST(LinearAlgebra, SingularVectorsGiveBackTheMatrix) {
  for (const auto& [rows, columns] : {std::pair<std::size_t, std::size_t>{9, 4}, {4, 9}, {6, 6}}) {
    const Matrix a = random_matrix(rows, columns, 23);
    const auto [u, values, v] = svd(a);
    const std::size_t k = std::min(rows, columns);
    ASSERT_EQ(u.columns, k);
    ASSERT_EQ(v.columns, columns);
    const double bound = 4.0 * static_cast<double>(rows * columns) * eps * values.front();
    EXPECT_LT(greatest(scaled_columns(u, values) * transposed(block(v, 0, columns, 0, k)) - a), bound);
    EXPECT_LT(greatest(gram(v) - identity(columns)), bound);
    EXPECT_TRUE(std::ranges::is_sorted(values, std::greater{}));
    if (columns > k) {
      EXPECT_LT(greatest(a * block(v, 0, columns, k, columns - k)), bound);
    }
    const auto alone = singular_values(a);
    for (std::size_t i = 0; i < k; ++i) EXPECT_NEAR(alone[i], values[i], bound);
  }
}

TEST(LinearAlgebra, ConditionIsTheRatioOfTheSingularValues) {
  EXPECT_NEAR(condition(diagonal(Vector{2.0, -8.0, 1.0})), 8.0, 8.0 * 3.0 * eps);
  EXPECT_EQ(condition(Matrix(3, 2)), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(singular_values(Matrix(2, 2, std::nan("")))[0]));
  EXPECT_TRUE(std::isnan(condition(Matrix(2, 2, std::nan("")))));
}

TEST(LinearAlgebra, PseudoInverseFulfilsThePenroseConditions) {
  Matrix a = random_matrix(7, 2, 24) * random_matrix(2, 5, 25);  // rank 2
  const Matrix inverse = pseudo_inverse(a, 1e-10);
  ASSERT_EQ(inverse.rows, 5u);
  ASSERT_EQ(inverse.columns, 7u);
  const auto values = singular_values(a);
  const double bound = 100.0 * eps * values[0] / values[1] * std::max({1.0, values[0], 1.0 / values[1]});
  const Matrix left = a * inverse, right = inverse * a;
  EXPECT_LT(greatest(left * a - a), bound);
  EXPECT_LT(greatest(right * inverse - inverse), bound);
  EXPECT_LT(greatest(left - transposed(left)), bound);
  EXPECT_LT(greatest(right - transposed(right)), bound);
}

TEST(LinearAlgebra, PseudoInverseDropsWhatIsBelowTheTolerance) {
  const Matrix a = diagonal(Vector{1.0, 1e-6, 0.0});
  EXPECT_NEAR(pseudo_inverse(a)(1, 1), 1e6, 1e6 * 4.0 * eps);
  EXPECT_EQ(pseudo_inverse(a, 1e-3)(1, 1), 0.0);
  EXPECT_EQ(pseudo_inverse(a)(2, 2), 0.0);
}

}  // namespace
}  // namespace tumble
