#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <utility>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/linear_algebra.hpp"

namespace tumble {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using Reflections = Eigen::HouseholderSequence<Eigen::Map<const MatrixXd>, Eigen::Map<const VectorXd>>;

/// Q, which reads the factors where they are.
Reflections reflections(const HouseholderQr& qr) {
  return Reflections(map(qr.packed), map(qr.coefficients)).setLength(at(qr.coefficients.size()));
}

}  // namespace

std::vector<double> solve(const Matrix& a, std::span<const double> b) { return solve(a, as_column(b)).values; }

Matrix solve(const Matrix& a, const Matrix& b) {
  assert(a.rows >= a.columns && a.rows == b.rows);
  if (a.columns == 0 || b.columns == 0) return {a.columns, b.columns};
  const MatrixXd matrix = map(a), right = map(b);
  if (a.rows == a.columns) return plain(Eigen::PartialPivLU<MatrixXd>(matrix).solve(right));
  return plain(Eigen::ColPivHouseholderQR<MatrixXd>(matrix).solve(right));
}

Matrix inverse(const Matrix& a) {
  assert(a.rows == a.columns);
  if (a.empty()) return a;
  return plain(Eigen::PartialPivLU<MatrixXd>(MatrixXd(map(a))).inverse());
}

double determinant(const Matrix& a) {
  assert(a.rows == a.columns);
  return a.empty() ? 1.0 : Eigen::PartialPivLU<MatrixXd>(MatrixXd(map(a))).determinant();
}

QrFit qr_fit(const Matrix& a, std::span<const double> b, double relative_tolerance) {
  assert(a.rows == b.size());
  QrFit out{std::vector<double>(a.columns), Matrix(a.columns, 0), 0, dot(b, b)};
  if (a.empty()) return out;
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  if (relative_tolerance > 0.0) qr.setThreshold(relative_tolerance);
  qr.compute(MatrixXd(map(a)));
  const Index rank = qr.rank();
  out.rank = static_cast<std::size_t>(rank);
  const MatrixXd upper = qr.matrixQR().topLeftCorner(rank, rank);
  const VectorXd rotated = qr.householderQ().adjoint() * map(b);
  const VectorXd x = upper.triangularView<Eigen::Upper>().solve(rotated.head(rank));
  MatrixXd root = MatrixXd::Identity(rank, rank);
  upper.triangularView<Eigen::Upper>().solveInPlace(root);
  MatrixXd placed = MatrixXd::Zero(at(a.columns), rank);
  for (Index k = 0; k < rank; ++k) {
    const Index column = qr.colsPermutation().indices()[k];
    out.x[static_cast<std::size_t>(column)] = x[k];
    placed.row(column) = root.row(k);
  }
  out.root = plain(placed);
  const auto rest = difference(b, a * out.x);
  out.residual_square = dot(rest, rest);
  return out;
}

HouseholderQr householder_qr(Matrix a) {
  if (a.empty()) return {a, {}};
  Eigen::Ref<MatrixXd> place = view(a);
  const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(place);  // in place: `a` becomes the packed factors
  const auto& coefficients = qr.hCoeffs();
  return {std::move(a), {coefficients.data(), coefficients.data() + coefficients.size()}};
}

Matrix upper_of(const HouseholderQr& qr) {
  Matrix out(std::min(qr.packed.rows, qr.packed.columns), qr.packed.columns);
  for (std::size_t j = 0; j < out.columns; ++j)
    for (std::size_t i = 0; i < std::min(out.rows, j + 1); ++i) out(i, j) = qr.packed(i, j);
  return out;
}

Matrix q_product(const HouseholderQr& qr, Matrix b) {
  assert(qr.packed.rows == b.rows);
  if (!b.empty() && !qr.packed.empty()) view(b).applyOnTheLeft(reflections(qr));
  return b;
}

std::vector<double> q_transposed_product(const HouseholderQr& qr, std::span<const double> b) {
  return q_transposed_product(qr, as_column(b)).values;
}

Matrix q_transposed_product(const HouseholderQr& qr, Matrix b) {
  assert(qr.packed.rows == b.rows);
  if (!b.empty() && !qr.packed.empty()) view(b).applyOnTheLeft(reflections(qr).adjoint());
  return b;
}

std::vector<double> solve(const HouseholderQr& qr, std::span<const double> b) { return solve(qr, as_column(b)).values; }

Matrix solve(const HouseholderQr& qr, const Matrix& b) {
  const std::size_t n = qr.packed.columns;
  assert(qr.packed.rows >= n);
  return solve_upper(block(qr.packed, 0, n, 0, n), block(q_transposed_product(qr, b), 0, n, 0, b.columns));
}

Matrix solve_upper(const Matrix& upper, Matrix b) {
  assert(upper.rows == upper.columns && upper.rows == b.rows);
  if (b.empty()) return b;
  auto x = view(b);
  map(upper).triangularView<Eigen::Upper>().solveInPlace(x);
  return b;
}

}  // namespace tumble
