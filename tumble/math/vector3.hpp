#pragma once

#include <cmath>

namespace tumble {

/// Components of a vector; the name of the variable says the frame and the comment the unit.
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;

  friend Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
};

/// Scalar product [u v] of vectors [u] and [v].
inline double dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector3 cross(Vector3 a, Vector3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Length [u] of a vector [u].
inline double norm(Vector3 a) { return std::sqrt(dot(a, a)); }

}  // namespace tumble
