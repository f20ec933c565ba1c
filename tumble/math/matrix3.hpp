#pragma once

#include <cassert>
#include <cstddef>

#include "tumble/math/matrix.hpp"
#include "tumble/math/vector3.hpp"

namespace tumble {

/// A matrix 3 x 3 as a value: its rows. Zero unless said otherwise. Rotation is one whose rows are orthonormal.
struct Matrix3 {
  Vector3 x, y, z;

  /// The element [row, column] [u], counted from 0.
  double& operator()(std::size_t row, std::size_t column) { return (*this)[row][column]; }
  double operator()(std::size_t row, std::size_t column) const { return (*this)[row][column]; }
  /// Row 0, 1 or 2 [u].
  Vector3& operator[](std::size_t row) { return row == 0 ? x : row == 1 ? y : z; }
  const Vector3& operator[](std::size_t row) const { return row == 0 ? x : row == 1 ? y : z; }

  friend Vector3 operator*(const Matrix3& m, Vector3 v) { return {dot(m.x, v), dot(m.y, v), dot(m.z, v)}; }
  friend Matrix3 operator*(double s, const Matrix3& m) { return {s * m.x, s * m.y, s * m.z}; }
  friend Matrix3 operator/(const Matrix3& m, double s) { return {m.x / s, m.y / s, m.z / s}; }
  friend Matrix3 operator+(const Matrix3& a, const Matrix3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Matrix3 operator-(const Matrix3& a, const Matrix3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Matrix3 operator-(const Matrix3& a) { return {-a.x, -a.y, -a.z}; }

  Matrix3& operator+=(const Matrix3& b) { return *this = *this + b; }
  Matrix3& operator-=(const Matrix3& b) { return *this = *this - b; }
};

/// The matrix with these values [u] on its diagonal and zeros elsewhere.
inline Matrix3 diagonal3(Vector3 v) { return {{v.x, 0.0, 0.0}, {0.0, v.y, 0.0}, {0.0, 0.0, v.z}}; }

/// The identity [1].
inline Matrix3 identity3() { return diagonal3({1.0, 1.0, 1.0}); }

/// The diagonal [u] of a matrix.
inline Vector3 diagonal_of(const Matrix3& m) { return {m.x.x, m.y.y, m.z.z}; }

/// Column 0, 1 or 2 [u].
inline Vector3 column(const Matrix3& m, std::size_t j) { return {m.x[j], m.y[j], m.z[j]}; }

/// Put a vector [u] into column 0, 1 or 2.
inline void set_column(Matrix3& m, std::size_t j, Vector3 v) { m.x[j] = v.x, m.y[j] = v.y, m.z[j] = v.z; }

/// Transpose [u].
inline Matrix3 transposed(const Matrix3& m) { return {column(m, 0), column(m, 1), column(m, 2)}; }

/// Product A B [u v].
inline Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  const Matrix3 t = transposed(b);
  return {t * a.x, t * a.y, t * a.z};
}

/// Determinant [u^3].
inline double determinant(const Matrix3& m) { return dot(m.x, cross(m.y, m.z)); }

/// Inverse [1/u] by cofactors; values that are not finite where the matrix is singular.
///
/// Accuracy  relative to 10 eps s_1^2/(s_2 s_3), s the singular values in descending order
inline Matrix3 inverse(const Matrix3& m) {
  const Vector3 a = cross(m.y, m.z), b = cross(m.z, m.x), c = cross(m.x, m.y);
  return transposed(Matrix3{a, b, c} / dot(m.x, a));
}

/// Outer product a b' [u v].
inline Matrix3 outer(Vector3 a, Vector3 b) { return {a.x * b, a.y * b, a.z * b}; }

/// The matrix [v x] [u] with [v x] w = v x w.
inline Matrix3 skew(Vector3 v) { return {{0.0, -v.z, v.y}, {v.z, 0.0, -v.x}, {-v.y, v.x, 0.0}}; }

/// A matrix [3 x 3] of any source as a value of that size.
inline Matrix3 matrix3(const Matrix& m) {
  assert(m.rows == 3 && m.columns == 3);
  return {{m(0, 0), m(0, 1), m(0, 2)}, {m(1, 0), m(1, 1), m(1, 2)}, {m(2, 0), m(2, 1), m(2, 2)}};
}

/// The elements [3 x 3] as a dense matrix.
inline Matrix dense(const Matrix3& m) {
  Matrix out(3, 3);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out(i, j) = m(i, j);
  return out;
}

}  // namespace tumble
