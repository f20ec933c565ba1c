#include "tumble/methods/imu_multi_position/start.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace tumble::imu_multi_position {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// sum_i (p_i y_i^2 + q_i y_i) = 1 in centred and scaled means.
std::optional<Linear> ellipsoid(const std::vector<Vector3d>& means, double gravity) {
  const auto n = static_cast<Eigen::Index>(means.size());
  if (n < 6) return {};
  Vector3d low = means[0], high = means[0];
  for (const auto& m : means) low = low.cwiseMin(m), high = high.cwiseMax(m);
  const Vector3d middle = 0.5 * (low + high);
  const double size = 0.5 * (high - low).maxCoeff();
  if (!(size > 0.0)) return {};
  Eigen::MatrixXd design(n, 6);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vector3d y = (means[static_cast<std::size_t>(k)] - middle) / size;
    design.row(k) << y.cwiseAbs2().transpose(), y.transpose();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  if (qr.rank() < 6) return {};
  const Eigen::VectorXd c = qr.solve(Eigen::VectorXd::Ones(n));
  double radius = 1.0;  // 1 + sum q^2/(4 p) of the completed squares
  for (int i = 0; i < 3; ++i) {
    if (!(c[i] > 0.0)) return {};
    radius += c[3 + i] * c[3 + i] / (4.0 * c[i]);
  }
  Linear out;
  for (int i = 0; i < 3; ++i) {
    out.bias[i] = middle[i] - size * c[3 + i] / (2.0 * c[i]);
    out.matrix(i, i) = size * std::sqrt(radius / c[i]) / gravity;
  }
  return out;
}

/// Derivative of |f| = |M^-1 (y - b)| with respect to the rows of lower triangular M, then b.
Vector9d derivative(const Matrix3d& inverse, const Vector3d& f) {
  const Vector3d v = -inverse.transpose() * f.normalized();
  Vector9d d;
  d << v[0] * f[0], v[1] * f[0], v[1] * f[1], v[2] * f[0], v[2] * f[1], v[2] * f[2], v[0], v[1], v[2];
  return d;
}

void add(const Vector9d& step, Linear& to) {
  to.matrix(0, 0) += step[0];
  to.matrix(1, 0) += step[1], to.matrix(1, 1) += step[2];
  to.matrix(2, 0) += step[3], to.matrix(2, 1) += step[4], to.matrix(2, 2) += step[5];
  to.bias += step.tail<3>();
}

/// 1 within three robust standard deviations, falling off beyond.
std::vector<double> robust_weights(const std::vector<double>& residual) {
  std::vector<double> size;
  for (const double r : residual) size.push_back(std::abs(r));
  std::nth_element(size.begin(), size.begin() + static_cast<long>(size.size() / 2), size.end());
  const double bound = 3.0 * 1.4826 * size[size.size() / 2];
  std::vector<double> weights;
  for (const double r : residual) weights.push_back(std::abs(r) <= bound ? 1.0 : bound * bound / (r * r));
  return weights;
}

}  // namespace

std::optional<Sphere> fit_sphere(const std::vector<Vector3d>& means, double gravity) {
  const auto start = ellipsoid(means, gravity);
  if (!start || means.size() < 12) return {};
  Sphere out{*start, std::vector<double>(means.size()), 0.0, 0.0};
  Vector9d size;  // one count for one m/s^2: makes the determinant one of relative numbers
  const double scale = start->matrix.diagonal().maxCoeff();
  size << 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, gravity, gravity, gravity;
  Matrix9d normal;
  constexpr int most = 12;
  for (int iteration = 0; iteration <= most; ++iteration) {
    const Matrix3d inverse = out.accelerometer.matrix.inverse();
    for (std::size_t k = 0; k < means.size(); ++k)
      out.residual[k] = (inverse * (means[k] - out.accelerometer.bias)).norm() - gravity;
    if (iteration == most) break;
    const auto weights = robust_weights(out.residual);
    normal.setZero();
    Vector9d right = Vector9d::Zero();
    for (std::size_t k = 0; k < means.size(); ++k) {
      const Vector9d d = derivative(inverse, inverse * (means[k] - out.accelerometer.bias)) * scale;
      normal += weights[k] * d * d.transpose();
      right -= weights[k] * out.residual[k] * d;
    }
    const Vector9d step = Eigen::LDLT<Matrix9d>(normal).solve(right) * scale;
    if (!step.allFinite()) return {};
    add(step, out.accelerometer);
    if ((step.array().abs() < 1e-13 * scale * size.array()).all()) break;
  }
  const auto weights = robust_weights(out.residual);
  double sum = 0.0;
  for (std::size_t k = 0; k < means.size(); ++k) sum += weights[k] * out.residual[k] * out.residual[k];
  out.scatter = std::sqrt(sum / static_cast<double>(means.size() - 9));
  if (!std::isfinite(out.scatter) || !(out.accelerometer.matrix.diagonal().array() > 0.0).all()) return {};
  const Matrix9d scaled = size.asDiagonal() * normal * size.asDiagonal();
  const double degrees = static_cast<double>(means.size() - 9);  // few: the scatter itself is not sure
  out.log_determinant = 9.0 * std::log(degrees / (degrees - 2.0)) +
                        18.0 * std::log(std::max(out.scatter, 1e-12 * gravity)) -
                        std::log(std::max(scaled.determinant(), 1e-300));
  return out;
}

}  // namespace tumble::imu_multi_position
