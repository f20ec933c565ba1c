#include <Eigen/Dense>
#include <cassert>
#include <utility>

#include "tumble/math/eigen/view.hpp"
#include "tumble/math/linear_algebra.hpp"

namespace tumble {
namespace {

/// The upper triangle from the lower one.
Matrix mirrored(Matrix a) {
  for (std::size_t j = 0; j < a.columns; ++j)
    for (std::size_t i = 0; i < j; ++i) a(i, j) = a(j, i);
  return a;
}

/// Rows times their weights, where there are some.
Matrix weighted(const Matrix& a, std::span<const double> w) { return w.empty() ? a : scaled_rows(w, a); }

/// half g', which is symmetric but for rounding.
Matrix times_transposed(const Matrix& half, const Matrix& g) {
  Matrix out(g.rows, g.rows);
  view(out).noalias() = map(half) * map(g).transpose();
  return mirrored(std::move(out));
}

}  // namespace

// The parameter itself is returned: a reference to it would be copied.
Matrix operator+(Matrix a, const Matrix& b) {
  a += b;
  return a;
}

Matrix operator-(Matrix a, const Matrix& b) {
  a -= b;
  return a;
}

Matrix& operator+=(Matrix& a, const Matrix& b) {
  assert(a.rows == b.rows && a.columns == b.columns);
  for (std::size_t k = 0; k < a.values.size(); ++k) a.values[k] += b.values[k];
  return a;
}

Matrix& operator-=(Matrix& a, const Matrix& b) {
  assert(a.rows == b.rows && a.columns == b.columns);
  for (std::size_t k = 0; k < a.values.size(); ++k) a.values[k] -= b.values[k];
  return a;
}

Matrix operator*(double factor, Matrix a) {
  a *= factor;
  return a;
}

Matrix& operator*=(Matrix& a, double factor) {
  for (double& value : a.values) value *= factor;
  return a;
}

Matrix operator*(const Matrix& a, const Matrix& b) {
  assert(a.columns == b.rows);
  Matrix out(a.rows, b.columns);
  view(out).noalias() = map(a) * map(b);
  return out;
}

std::vector<double> operator*(const Matrix& a, std::span<const double> x) {
  assert(a.columns == x.size());
  std::vector<double> out(a.rows);
  Eigen::Map<Eigen::VectorXd>(out.data(), at(a.rows)).noalias() = map(a) * map(x);
  return out;
}

Matrix transposed_product(const Matrix& a, const Matrix& b) {
  assert(a.rows == b.rows);
  Matrix out(a.columns, b.columns);
  view(out).noalias() = map(a).transpose() * map(b);
  return out;
}

std::vector<double> transposed_product(const Matrix& a, std::span<const double> x) {
  assert(a.rows == x.size());
  std::vector<double> out(a.columns);
  Eigen::Map<Eigen::VectorXd>(out.data(), at(a.columns)).noalias() = map(a).transpose() * map(x);
  return out;
}

Matrix scaled_rows(std::span<const double> w, Matrix a) {
  assert(w.size() == a.rows);
  for (std::size_t j = 0; j < a.columns; ++j)
    for (std::size_t i = 0; i < a.rows; ++i) a(i, j) *= w[i];
  return a;
}

Matrix scaled_columns(Matrix a, std::span<const double> w) {
  assert(w.size() == a.columns);
  for (std::size_t j = 0; j < a.columns; ++j)
    for (double& value : column(a, j)) value *= w[j];
  return a;
}

Matrix outer(std::span<const double> a, std::span<const double> b) {
  Matrix out(a.size(), b.size());
  for (std::size_t j = 0; j < b.size(); ++j)
    for (std::size_t i = 0; i < a.size(); ++i) out(i, j) = a[i] * b[j];
  return out;
}

void add_square(Matrix& to, double factor, std::span<const double> x) {
  assert(to.rows == x.size() && to.columns == x.size());
  for (std::size_t j = 0; j < x.size(); ++j)
    for (std::size_t i = 0; i < x.size(); ++i) to(i, j) += factor * (x[i] * x[j]);
}

Matrix gram(const Matrix& a, std::span<const double> w) {
  return mirrored(w.empty() ? transposed_product(a, a) : transposed_product(a, scaled_rows(w, a)));
}

NormalEquations normal_equations(const Matrix& a, std::span<const double> w, std::span<const double> y) {
  return {gram(a, w), transposed_product(weighted(a, w), y)};
}

Matrix sandwich(const Matrix& g, const Matrix& v) { return times_transposed(g * v, g); }

Matrix sandwich(const Matrix& g, std::span<const double> v) { return times_transposed(scaled_columns(g, v), g); }

double quadratic_form(std::span<const double> x, const Matrix& v) { return dot(x, v * x); }

}  // namespace tumble
