#include "tumble/math/symmetric_factor.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

constexpr double enough = 1e-14;  ///< of the scale: rounding

/// Row of the greatest remaining diagonal element, relative to its scale.
std::size_t pivot_of(const Matrix& rest, const std::vector<double>& scale) {
  std::size_t pivot = 0;
  double greatest = -1.0;
  for (std::size_t i = 0; i < rest.rows; ++i)
    if (scale[i] > 0.0 && rest(i, i) / scale[i] > greatest) {
      greatest = rest(i, i) / scale[i];
      pivot = i;
    }
  return pivot;
}

double excess_of(const Matrix& rest, const std::vector<double>& scale) {
  double excess = 0.0;
  for (std::size_t i = 0; i < rest.rows; ++i)
    for (std::size_t j = 0; j < rest.rows; ++j) {
      if (rest(i, j) == 0.0) continue;
      const double size = std::sqrt(scale[i]) * std::sqrt(scale[j]);
      excess = std::max(excess, size > 0.0 ? std::abs(rest(i, j)) / size : INFINITY);
    }
  return excess;
}

}  // namespace

SymmetricFactor symmetric_factor(const Matrix& matrix, std::vector<double> scale) {
  const std::size_t p = matrix.rows;
  Matrix rest = matrix;
  if (scale.empty())
    for (std::size_t i = 0; i < p; ++i) scale.push_back(matrix(i, i));
  SymmetricFactor out{Matrix(p, 0), 0.0};
  for (std::size_t rank = 0; rank < p; ++rank) {
    const std::size_t k = pivot_of(rest, scale);
    if (!(rest(k, k) > enough * scale[k]) || !(scale[k] > 0.0)) break;
    const double root = std::sqrt(rest(k, k));
    std::vector<double> column(p);
    for (std::size_t i = 0; i < p; ++i) column[i] = i == k ? root : 0.5 * (rest(i, k) + rest(k, i)) / root;
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t j = 0; j < p; ++j) rest(i, j) -= column[i] * column[j];
    for (std::size_t i = 0; i < p; ++i) rest(i, k) = rest(k, i) = 0.0;
    out.factor.values.insert(out.factor.values.end(), column.begin(), column.end());
    ++out.factor.columns;
  }
  out.excess = excess_of(rest, scale);
  return out;
}

}  // namespace tumble
