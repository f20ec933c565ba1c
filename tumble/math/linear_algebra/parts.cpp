#include <algorithm>
#include <cassert>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble {

double dot(std::span<const double> a, std::span<const double> b) {
  assert(a.size() == b.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

double norm(std::span<const double> a) { return std::sqrt(dot(a, a)); }

std::vector<double> difference(std::span<const double> a, std::span<const double> b) { return scaled_sum(a, -1.0, b); }

std::vector<double> scaled_sum(std::span<const double> a, double factor, std::span<const double> b) {
  assert(a.size() == b.size());
  std::vector<double> out(a.begin(), a.end());
  for (std::size_t i = 0; i < b.size(); ++i) out[i] += factor * b[i];
  return out;
}

std::vector<double> scaled(double factor, std::span<const double> a) {
  std::vector<double> out(a.begin(), a.end());
  for (double& value : out) value *= factor;
  return out;
}

std::vector<double> scaled(std::span<const double> w, std::span<const double> a) {
  assert(w.size() == a.size());
  std::vector<double> out(a.begin(), a.end());
  for (std::size_t i = 0; i < w.size(); ++i) out[i] *= w[i];
  return out;
}

std::vector<double> inverses(std::span<const double> a, double least) {
  std::vector<double> out;
  out.reserve(a.size());
  for (const double value : a) out.push_back(1.0 / std::max(value, least));
  return out;
}

Matrix identity(std::size_t n) { return diagonal(std::vector<double>(n, 1.0)); }

Matrix diagonal(std::span<const double> values) {
  Matrix out(values.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) out(i, i) = values[i];
  return out;
}

std::vector<double> diagonal_of(const Matrix& a) {
  std::vector<double> out(std::min(a.rows, a.columns));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a(i, i);
  return out;
}

double trace(const Matrix& a) {
  assert(a.rows == a.columns);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.rows; ++i) sum += a(i, i);
  return sum;
}

Matrix as_column(std::span<const double> values) {
  Matrix out(values.size(), 1);
  std::ranges::copy(values, out.values.begin());
  return out;
}

std::span<double> column(Matrix& a, std::size_t j) {
  assert(j < a.columns);
  return std::span<double>(a.values).subspan(j * a.rows, a.rows);
}

std::span<const double> column(const Matrix& a, std::size_t j) {
  assert(j < a.columns);
  return std::span<const double>(a.values).subspan(j * a.rows, a.rows);
}

std::vector<double> row(const Matrix& a, std::size_t i) {
  assert(i < a.rows);
  std::vector<double> out(a.columns);
  for (std::size_t j = 0; j < a.columns; ++j) out[j] = a(i, j);
  return out;
}

Matrix block(const Matrix& a, std::size_t first_row, std::size_t rows, std::size_t first_column, std::size_t columns) {
  assert(first_row + rows <= a.rows && first_column + columns <= a.columns);
  Matrix out(rows, columns);
  for (std::size_t j = 0; j < columns; ++j)
    std::ranges::copy(column(a, first_column + j).subspan(first_row, rows), column(out, j).begin());
  return out;
}

void set_block(Matrix& to, std::size_t first_row, std::size_t first_column, const Matrix& part) {
  assert(first_row + part.rows <= to.rows && first_column + part.columns <= to.columns);
  for (std::size_t j = 0; j < part.columns; ++j)
    std::ranges::copy(column(part, j), column(to, first_column + j).subspan(first_row).begin());
}

Matrix chosen_rows(const Matrix& a, std::span<const std::size_t> rows) {
  Matrix out(rows.size(), a.columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    assert(rows[i] < a.rows);
    for (std::size_t j = 0; j < a.columns; ++j) out(i, j) = a(rows[i], j);
  }
  return out;
}

Matrix chosen_columns(const Matrix& a, std::span<const std::size_t> columns) {
  Matrix out(a.rows, columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) std::ranges::copy(column(a, columns[j]), column(out, j).begin());
  return out;
}

Matrix stacked(const Matrix& top, const Matrix& bottom) {
  if (top.rows + top.columns == 0) return bottom;
  if (bottom.rows + bottom.columns == 0) return top;
  assert(top.columns == bottom.columns);
  Matrix out(top.rows + bottom.rows, top.columns);
  set_block(out, 0, 0, top);
  set_block(out, top.rows, 0, bottom);
  return out;
}

Matrix beside(const Matrix& left, const Matrix& right) {
  if (left.rows + left.columns == 0) return right;
  if (right.rows + right.columns == 0) return left;
  assert(left.rows == right.rows);
  Matrix out = left;
  out.columns += right.columns;
  out.values.insert(out.values.end(), right.values.begin(), right.values.end());
  return out;
}

Matrix transposed(const Matrix& a) {
  Matrix out(a.columns, a.rows);
  for (std::size_t j = 0; j < a.columns; ++j)
    for (std::size_t i = 0; i < a.rows; ++i) out(j, i) = a(i, j);
  return out;
}

std::vector<double> column_norms(const Matrix& a) {
  std::vector<double> out(a.columns);
  for (std::size_t j = 0; j < a.columns; ++j) out[j] = norm(column(a, j));
  return out;
}

}  // namespace tumble
