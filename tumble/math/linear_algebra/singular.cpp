#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/linear_algebra.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Svd svd(const Matrix& a) {
  const std::size_t k = std::min(a.rows, a.columns);
  if (a.empty()) return {Matrix(a.rows, 0), {}, identity(a.columns)};
  const Eigen::JacobiSVD<MatrixXd> solver(MatrixXd(map(a)), Eigen::ComputeThinU | Eigen::ComputeFullV);
  if (solver.info() != Eigen::Success)
    return {Matrix(a.rows, k, nan), std::vector<double>(k, nan), Matrix(a.columns, a.columns, nan)};
  const auto& values = solver.singularValues();
  return {plain(solver.matrixU()), {values.data(), values.data() + values.size()}, plain(solver.matrixV())};
}

std::vector<double> singular_values(const Matrix& a) {
  if (a.empty()) return {};
  const Eigen::JacobiSVD<MatrixXd> solver(MatrixXd(map(a)), 0);
  const auto& values = solver.singularValues();
  if (solver.info() != Eigen::Success) return std::vector<double>(std::min(a.rows, a.columns), nan);
  return {values.data(), values.data() + values.size()};
}

double condition(const Matrix& a) {
  const auto values = singular_values(a);
  if (values.empty()) return 1.0;
  return values.back() == 0.0 ? std::numeric_limits<double>::infinity() : values.front() / values.back();
}

Matrix pseudo_inverse(const Matrix& a, double relative_tolerance) {
  if (a.empty()) return {a.columns, a.rows};
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  if (relative_tolerance > 0.0) decomposition.setThreshold(relative_tolerance);
  decomposition.compute(MatrixXd(map(a)));
  return plain(decomposition.pseudoInverse());
}

}  // namespace tumble
