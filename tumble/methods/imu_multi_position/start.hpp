#pragma once

#include <optional>
#include <vector>

#include "tumble/methods/imu_multi_position/data.hpp"

namespace tumble::imu_multi_position {

/// y = matrix u + bias, in the unit of the channels.
struct Linear {
  Matrix3d matrix = Matrix3d::Identity();
  Vector3d bias = Vector3d::Zero();
};

/// A calibration from |f| alone, lower triangular.
struct Sphere {
  Linear accelerometer;
  std::vector<double> residual;  ///< |f| - gravity [m/s^2], one a mean
  double scatter = 0.0;          ///< [m/s^2] sd of them, by the degrees of freedom
  double log_determinant = 0.0;  ///< of the covariance of the nine coefficients relative to their size
};

/// From means at rest: first the ellipsoid with axes along those of the triad, linear in its six coefficients, then
/// Gauss-Newton with all nine. Means with robust weights, so that single bad ones do no harm.
/// Null where the means do not show an ellipsoid. Given: means [output unit], gravity [m/s^2].
std::optional<Sphere> fit_sphere(const std::vector<Vector3d>& means, double gravity);

}  // namespace tumble::imu_multi_position
