#include <Eigen/Dense>
#include <cassert>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/linear_algebra.hpp"

namespace tumble {

using Eigen::MatrixXd;

std::vector<double> solve_symmetric(const Matrix& a, std::span<const double> b) {
  return solve_symmetric(a, as_column(b)).values;
}

Matrix solve_symmetric(const Matrix& a, const Matrix& b) {
  assert(a.rows == a.columns && a.rows == b.rows);
  if (b.empty()) return b;
  const Eigen::LDLT<MatrixXd> factor(map(a));
  Matrix x(b.rows, b.columns);
  view(x) = factor.solve(map(b));
  return x;
}

Matrix inverse_symmetric(const Matrix& a) {
  Matrix out = solve_symmetric(a, identity(a.rows));
  for (std::size_t j = 0; j < out.columns; ++j)
    for (std::size_t i = 0; i < j; ++i) out(i, j) = out(j, i) = 0.5 * (out(i, j) + out(j, i));
  return out;
}

Cholesky cholesky(const Matrix& a) {
  assert(a.rows == a.columns);
  if (a.empty()) return {{}, 0.0, true};
  Cholesky out{a, 0.0, false};
  Eigen::Ref<MatrixXd> place = view(out.lower);
  out.positive = Eigen::LLT<Eigen::Ref<MatrixXd>>(place).info() == Eigen::Success;  // in place
  for (std::size_t j = 0; j < a.columns; ++j) {
    const double pivot = out.lower(j, j);
    out.positive = out.positive && pivot > 0.0 && std::isfinite(pivot);
    out.log_determinant += 2.0 * std::log(pivot);
    for (std::size_t i = 0; i < j; ++i) out.lower(i, j) = 0.0;
  }
  if (!out.positive) return {{}, std::numeric_limits<double>::quiet_NaN(), false};
  return out;
}

std::vector<double> solve(const Cholesky& factor, std::span<const double> b) {
  return solve(factor, as_column(b)).values;
}

Matrix solve(const Cholesky& factor, const Matrix& b) {
  assert(factor.positive);
  return solve_lower_transposed(factor.lower, solve_lower(factor.lower, b));
}

std::vector<double> solve_lower(const Matrix& lower, std::span<const double> b) {
  return solve_lower(lower, as_column(b)).values;
}

Matrix solve_lower(const Matrix& lower, Matrix b) {
  assert(lower.rows == lower.columns && lower.rows == b.rows);
  if (b.empty()) return b;
  auto x = view(b);
  map(lower).triangularView<Eigen::Lower>().solveInPlace(x);
  return b;
}

std::vector<double> solve_lower_transposed(const Matrix& lower, std::span<const double> b) {
  return solve_lower_transposed(lower, as_column(b)).values;
}

Matrix solve_lower_transposed(const Matrix& lower, Matrix b) {
  assert(lower.rows == lower.columns && lower.rows == b.rows);
  if (b.empty()) return b;
  auto x = view(b);
  map(lower).transpose().triangularView<Eigen::Upper>().solveInPlace(x);
  return b;
}

SymmetricEigen eigen_symmetric(const Matrix& a) {
  assert(a.rows == a.columns);
  if (a.empty()) return {};
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver{MatrixXd(map(a))};
  const auto& values = solver.eigenvalues();
  return {{values.data(), values.data() + values.size()}, plain(solver.eigenvectors())};
}

std::vector<double> eigenvalues_symmetric(const Matrix& a) {
  assert(a.rows == a.columns);
  if (a.empty()) return {};
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(MatrixXd(map(a)), Eigen::EigenvaluesOnly);
  const auto& values = solver.eigenvalues();
  return {values.data(), values.data() + values.size()};
}

}  // namespace tumble
