#pragma once

#include "tumble/math/vector3.hpp"

namespace tumble {

/// A passive rotation: components in the new axes from those in the old, v_new = R v_old. The rows are the new axes
/// seen in the old ones.
struct Rotation {
  Vector3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};

  friend Vector3 operator*(const Rotation& r, Vector3 v) { return {dot(r.x, v), dot(r.y, v), dot(r.z, v)}; }
};

/// Old from new: the transpose.
inline Rotation inverse(const Rotation& r) {
  return {{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}};
}

/// First `b`, then `a`: c_from_a = c_from_b * b_from_a.
inline Rotation operator*(const Rotation& a, const Rotation& b) {
  const Rotation t = inverse(b);
  return {{dot(a.x, t.x), dot(a.x, t.y), dot(a.x, t.z)},
          {dot(a.y, t.x), dot(a.y, t.y), dot(a.y, t.z)},
          {dot(a.z, t.x), dot(a.z, t.y), dot(a.z, t.z)}};
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

/// Axes turned by `angle` [rad] about one of them.
inline Rotation about_x(double angle) { return about({1.0, 0.0, 0.0}, angle); }
inline Rotation about_y(double angle) { return about({0.0, 1.0, 0.0}, angle); }
inline Rotation about_z(double angle) { return about({0.0, 0.0, 1.0}, angle); }

}  // namespace tumble
