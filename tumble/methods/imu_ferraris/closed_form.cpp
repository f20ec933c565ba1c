#include "tumble/methods/imu_ferraris/closed_form.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::imu_ferraris {
namespace {

constexpr double least_reciprocal_condition = 1e-3;  ///< of the accelerometers: axes 0.06 deg apart, or one silent

/// The poses of that sign as columns.
Matrix3 columns(const std::array<Vector3, poses>& means, std::size_t first) {
  Matrix3 m;
  for (std::size_t axis = 0; axis < 3; ++axis) set_column(m, axis, means[2 * axis + first]);
  return m;
}

void split(const Matrix3& response, Vector3& k, Matrix3& r) {
  for (std::size_t i = 0; i < 3; ++i) {
    k[i] = norm(response[i]);
    r[i] = 1.0 / k[i] * response[i];
  }
}

/// Greatest sum of sizes over a column.
double column_norm(const Matrix3& m) {
  const auto size = [&](std::size_t j) { return std::abs(m(0, j)) + std::abs(m(1, j)) + std::abs(m(2, j)); };
  return std::max({size(0), size(1), size(2)});
}

}  // namespace

Matrix3 response(Vector3 k, const Matrix3& r) { return {k.x * r.x, k.y * r.y, k.z * r.z}; }

Calibration closed_form(const Means& means) {
  Calibration out;
  out.gyros = means.gyros;
  const Matrix3 up = columns(means.force, 0), down = columns(means.force, 1);
  const Matrix3 accelerometers = (up - down) / (2.0 * means.gravity), force_of = inverse(accelerometers);
  out.b_a = 0.5 * diagonal_of(up + down);
  split(accelerometers, out.k_a, out.r_a);
  const double reciprocal_condition = 1.0 / (column_norm(accelerometers) * column_norm(force_of));
  if (!(reciprocal_condition >= least_reciprocal_condition))
    throw Error(Error::Kind::bad_data,
                "the six poses do not show three axes of the accelerometers: two outputs are equal, or one is silent");
  if (!means.gyros) return out;
  const Matrix3 sensitivity = (columns(means.rate, 0) - columns(means.rate, 1)) / (2.0 * means.gravity);
  Vector3 b_g;
  double samples = 0.0;
  for (std::size_t p = 0; p < poses; ++p) {
    b_g += means.samples[p] * means.rate[p];
    samples += means.samples[p];
  }
  b_g = b_g / samples;
  Matrix3 gyros;
  for (std::size_t t = 0; t < turns; ++t) {
    const Vector3 still = sensitivity * (force_of * (means.turn_force[t] - out.b_a)) + b_g;
    set_column(gyros, t, (means.turned[t] - means.turn_time[t] * still) / means.angle[t]);
  }
  split(gyros, out.k_g, out.r_g);
  out.b_g = b_g;
  out.k_ga = sensitivity;
  return out;
}

std::vector<double> parameters_of(const Calibration& c) {
  std::vector<double> all;
  const auto add = [&](Vector3 k, Vector3 b, const Matrix3& r, std::size_t i) {
    all.insert(all.end(), {k[i], b[i]});
    for (std::size_t j = 0; j < 3; ++j)
      if (j != i) all.push_back(r(i, j));
  };
  for (std::size_t i = 0; i < 3; ++i) add(c.k_a, c.b_a, c.r_a, i);
  for (std::size_t i = 0; i < 3 && c.gyros; ++i) {
    add(c.k_g, c.b_g, c.r_g, i);
    for (std::size_t j = 0; j < 3; ++j) all.push_back(c.k_ga(i, j));
  }
  return all;
}

}  // namespace tumble::imu_ferraris
