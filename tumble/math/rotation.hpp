#pragma once

#include "tumble/math/matrix3.hpp"
#include "tumble/math/vector3.hpp"

namespace tumble {

/// A passive rotation: components in the new axes from those in the old, v_new = R v_old. The rows are the new axes
/// seen in the old ones.
struct Rotation {
  Vector3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};

  friend Vector3 operator*(const Rotation& r, Vector3 v) { return {dot(r.x, v), dot(r.y, v), dot(r.z, v)}; }
};

/// The cosines [1] of a rotation as a matrix.
inline Matrix3 matrix3(const Rotation& r) { return {r.x, r.y, r.z}; }

/// Old from new: the transpose.
inline Rotation inverse(const Rotation& r) {
  const Matrix3 t = transposed(matrix3(r));
  return {t.x, t.y, t.z};
}

/// First `b`, then `a`: c_from_a = c_from_b * b_from_a.
inline Rotation operator*(const Rotation& a, const Rotation& b) {
  const Matrix3 p = matrix3(a) * matrix3(b);
  return {p.x, p.y, p.z};
}

/// Axes turned by `angle` [rad], right-handed, about the unit vector `axis` (the same in both frames).
///
///   R = cos a I + (1 - cos a) n n' - sin a [n x]
inline Rotation about(Vector3 axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), k = 1.0 - c;
  const Vector3 n = axis;
  return {{c + k * n.x * n.x, k * n.x * n.y + s * n.z, k * n.x * n.z - s * n.y},
          {k * n.y * n.x - s * n.z, c + k * n.y * n.y, k * n.y * n.z + s * n.x},
          {k * n.z * n.x + s * n.y, k * n.z * n.y - s * n.x, c + k * n.z * n.z}};
}

/// Axes turned by the rotation vector v [rad]: about its direction, by its length t.
///
///   R = cos t I + (1 - cos t)/t^2 v v' - (sin t)/t [v x]
///
/// The inverse turns vectors by v. Series to t^6 below 0.1 rad, so that small turns are exact to 1e-14.
inline Rotation turned_by(Vector3 v) {
  const double square = dot(v, v), t = std::sqrt(square);
  double s = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0));   // sin t / t
  double c = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0));  // (1 - cos t)/t^2
  if (square > 0.01) s = std::sin(t) / t, c = (1.0 - std::cos(t)) / square;
  const Matrix3 m = c * outer(v, v) - s * skew(v) + diagonal3({1.0 - c * square, 1.0 - c * square, 1.0 - c * square});
  return {m.x, m.y, m.z};
}

/// Axes turned by `angle` [rad] about one of them.
inline Rotation about_x(double angle) { return about({1.0, 0.0, 0.0}, angle); }
inline Rotation about_y(double angle) { return about({0.0, 1.0, 0.0}, angle); }
inline Rotation about_z(double angle) { return about({0.0, 0.0, 1.0}, angle); }

}  // namespace tumble
