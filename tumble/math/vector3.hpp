#pragma once

#include <cmath>
#include <cstddef>

namespace tumble {

/// Components of a vector; the name of the variable says the frame and the comment the unit.
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;

  friend Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
  friend Vector3 operator/(Vector3 a, double s) { return {a.x / s, a.y / s, a.z / s}; }
  friend Vector3 operator-(Vector3 a) { return {-a.x, -a.y, -a.z}; }

  Vector3& operator+=(Vector3 b) { return *this = *this + b; }
  Vector3& operator-=(Vector3 b) { return *this = *this - b; }
  /// Every component times s [u].
  Vector3& operator*=(double s) { return *this = s * *this; }
  /// Component 0, 1 or 2 [u].
  double& operator[](std::size_t i) { return i == 0 ? x : i == 1 ? y : z; }
  double operator[](std::size_t i) const { return i == 0 ? x : i == 1 ? y : z; }
};

/// Scalar product [u v] of vectors [u] and [v].
inline double dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector3 cross(Vector3 a, Vector3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Length [u] of a vector [u].
inline double norm(Vector3 a) { return std::sqrt(dot(a, a)); }

/// A vector of length 1 [1] in the direction of a vector [u]; not numbers where that is zero.
inline Vector3 normalised(Vector3 a) { return a / norm(a); }

/// Component by component: w_i a_i [u v].
inline Vector3 scaled(Vector3 w, Vector3 a) { return {w.x * a.x, w.y * a.y, w.z * a.z}; }

/// Magnitudes of the components [u].
inline Vector3 absolute(Vector3 a) { return {std::abs(a.x), std::abs(a.y), std::abs(a.z)}; }

/// Whether all components [u] are finite.
inline bool is_finite(Vector3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// A vector of length 1 [1] at a right angle to a vector [u]: in the plane xy, except for vectors along z.
inline Vector3 unit_across(Vector3 a) {
  const bool along_z = std::hypot(a.x, a.y) <= 1e-12 * std::abs(a.z);
  return normalised(along_z ? Vector3{0.0, -a.z, a.y} : Vector3{-a.y, a.x, 0.0});
}

}  // namespace tumble
