#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "tumble/math/matrix3.hpp"
#include "tumble/methods/imu_multi_position/data.hpp"

namespace tumble::imu_multi_position {

/// y = matrix u + bias, in the unit of the channels.
struct Linear {
  Matrix3 matrix = identity3();
  Vector3 bias;
};

/// u = matrix (y - bias): a Linear inverted once for many samples.
struct Inverse {
  Matrix3 matrix;
  Vector3 bias;
  explicit Inverse(const Linear& of) : matrix(inverse(of.matrix)), bias(of.bias) {}
  /// u [input] of y [unit of the channels].
  Vector3 operator()(Vector3 y) const { return matrix * (y - bias); }
};

/// Coefficients of a lower triangular matrix M (xx, yx, yy, zx, zy, zz), then of a bias.
inline constexpr std::size_t of_accelerometers = 9;
using Coefficients = std::array<double, of_accelerometers>;

/// Derivative [9] of v' (M u + bias) [v y] with respect to the coefficients: v_i u_j, then v.
Coefficients derivative(Vector3 v, Vector3 u);

/// Adds a change of the coefficients [9].
void add(std::span<const double> step, Linear& to);

/// Least and greatest component of each axis [u].
struct Box {
  Vector3 low, high;
  Vector3 middle() const { return 0.5 * (low + high); }
};
Box box_of(const std::vector<Vector3>& means);

/// A calibration from |f| alone, lower triangular.
struct Sphere {
  Linear accelerometer;
  std::vector<double> residual;  ///< |f| - gravity [m/s^2], one for each mean
  double scatter = 0.0;          ///< [m/s^2] sd of them, by the degrees of freedom
  double log_determinant = 0.0;  ///< of the covariance of the nine coefficients relative to their size
};

/// From means at rest: first the ellipsoid with axes along those of the triad, linear in its six coefficients, then
/// Gauss-Newton with all nine. Means have robust weights, so that single outliers do no harm.
/// Null where the means do not show an ellipsoid. Given: means [output unit], gravity [m/s^2].
std::optional<Sphere> fit_sphere(const std::vector<Vector3>& means, double gravity);

}  // namespace tumble::imu_multi_position
