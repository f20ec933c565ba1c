#include "tumble/exchange/exports/writing/factor.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/units/error.hpp"

namespace tumble::writing {
namespace {

void require_right_handed(const Matrix3& response, const char* what) {
  if (determinant(response) > 0.0) return;
  throw Error(Error::Kind::bad_input,
              say("the {} show left-handed axes (one is reversed or two are exchanged): no rotation turns them into "
                  "those of the consumer; correct the wiring in [channels]",
                  what));
}

/// `v` less its parts along unit vectors, twice, so that rounding leaves it at right angles.
Vector3 across(Vector3 v, Vector3 a) {
  v = v - dot(v, a) * a;
  return v - dot(v, a) * a;
}

}  // namespace

Factored lower_factor(const Matrix3& k, const char* what) {
  require_right_handed(k, what);
  Factored f;
  f.rotation.x = normalised(k.x);
  f.rotation.y = normalised(across(k.y, f.rotation.x));
  f.rotation.z = cross(f.rotation.x, f.rotation.y);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j <= i; ++j) f.triangle(i, j) = dot(k[i], f.rotation[j]);
  return f;
}

Factored upper_factor(const Matrix3& k, const char* what) {
  require_right_handed(k, what);
  Factored f;
  f.rotation.z = normalised(k.z);
  f.rotation.y = normalised(across(k.y, f.rotation.z));
  f.rotation.x = cross(f.rotation.y, f.rotation.z);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j) f.triangle(i, j) = dot(k[i], f.rotation[j]);
  return f;
}

double angle_of(const Matrix3& r) {
  const Vector3 turned{r(1, 2) - r(2, 1), r(2, 0) - r(0, 2), r(0, 1) - r(1, 0)};
  return std::atan2(0.5 * norm(turned), 0.5 * (r(0, 0) + r(1, 1) + r(2, 2) - 1.0));
}

}  // namespace tumble::writing
