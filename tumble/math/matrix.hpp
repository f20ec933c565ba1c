#pragma once

#include <cstddef>
#include <vector>

namespace tumble {

/// A dense matrix as a plain value, column after column. Headers speak of this; only the .cpp files that calculate see
/// Eigen, through Eigen::Map.
struct Matrix {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values;  ///< rows * columns, column-major

  Matrix() = default;
  /// A matrix [r x c] of this value.
  Matrix(std::size_t r, std::size_t c, double fill = 0.0) : rows(r), columns(c), values(r * c, fill) {}

  /// The element [row, column], counted from 0.
  double& operator()(std::size_t row, std::size_t column) { return values[column * rows + row]; }
  double operator()(std::size_t row, std::size_t column) const { return values[column * rows + row]; }
  bool empty() const { return values.empty(); }
};

}  // namespace tumble
