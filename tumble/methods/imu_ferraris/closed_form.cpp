#include "tumble/methods/imu_ferraris/closed_form.hpp"

#include <Eigen/LU>

#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_ferraris {
namespace {

using Three = Eigen::Matrix3d;
using Vector = Eigen::Vector3d;

Vector eigen(Vector3 v) { return {v.x, v.y, v.z}; }
Vector3 plain(const Vector& v) { return {v.x(), v.y(), v.z()}; }

Matrix plain(const Three& m) {
  Matrix out(3, 3);
  Eigen::Map<Three>(out.values.data()) = m;
  return out;
}

/// The poses of that sign as columns.
Three columns(const std::array<Vector3, poses>& means, std::size_t first) {
  Three m;
  for (int axis = 0; axis < 3; ++axis) m.col(axis) = eigen(means[2 * static_cast<std::size_t>(axis) + first]);
  return m;
}

void split(const Three& response, Vector3& k, Matrix& r) {
  const Vector lengths = response.rowwise().norm();
  k = plain(lengths);
  r = plain(Three(lengths.cwiseInverse().asDiagonal() * response));
}

}  // namespace

Matrix response(Vector3 k, const Matrix& r) {
  Matrix out(3, 3);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) out(i, j) = imu::component(k, i) * r(i, j);
  return out;
}

Calibration closed_form(const Means& means) {
  Calibration out;
  out.gyros = means.gyros;
  const Three up = columns(means.force, 0), down = columns(means.force, 1);
  const Three accelerometers = (up - down) / (2.0 * means.gravity);
  const Vector b_a = 0.5 * (up + down).diagonal();
  out.b_a = plain(b_a);
  split(accelerometers, out.k_a, out.r_a);
  const Eigen::FullPivLU<Three> force_of(accelerometers);
  if (!accelerometers.allFinite() || force_of.rcond() < 1e-3)
    throw Error(
        Error::Kind::bad_data,
        "the six poses do not show three axes of the accelerometers: two outputs are the same, or one is silent");
  if (!means.gyros) return out;
  const Three sensitivity = (columns(means.rate, 0) - columns(means.rate, 1)) / (2.0 * means.gravity);
  Vector b_g = Vector::Zero();
  double samples = 0.0;
  for (std::size_t p = 0; p < poses; ++p) {
    b_g += means.samples[p] * eigen(means.rate[p]);
    samples += means.samples[p];
  }
  b_g /= samples;
  Three gyros;
  for (std::size_t t = 0; t < turns; ++t) {
    const Vector still = sensitivity * force_of.solve(eigen(means.turn_force[t]) - b_a) + b_g;
    gyros.col(static_cast<int>(t)) = (eigen(means.turned[t]) - means.turn_time[t] * still) / means.angle[t];
  }
  split(gyros, out.k_g, out.r_g);
  out.b_g = plain(b_g);
  out.k_ga = plain(sensitivity);
  return out;
}

std::vector<double> parameters_of(const Calibration& c) {
  std::vector<double> all;
  const auto add = [&](Vector3 k, Vector3 b, const Matrix& r, std::size_t i) {
    all.push_back(imu::component(k, i));
    all.push_back(imu::component(b, i));
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
