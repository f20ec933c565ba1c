#include "tumble/methods/imu_multi_position/start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr double outside_sd = 3.0;  ///< [sd] of the start, beyond which a rest is not used in it
constexpr int most_iterations = 12;
constexpr double last_step = 1e-13;           ///< [1] of a coefficient: rounding
constexpr std::size_t fewest_of_sphere = 12;  ///< rests, for nine coefficients
constexpr double least_scatter = 1e-12;       ///< [1] of gravity: for data without noise

double greatest(Vector3 v) { return std::max({v.x, v.y, v.z}); }

/// sum_i (p_i y_i^2 + q_i y_i) = 1 in centred and scaled means.
std::optional<Linear> ellipsoid(const std::vector<Vector3>& means, double gravity) {
  if (means.size() < 6) return {};
  const Box box = box_of(means);
  const Vector3 middle = box.middle();
  const double size = 0.5 * greatest(box.high - box.low);
  if (!(size > 0.0)) return {};
  Matrix design(means.size(), 6);
  for (std::size_t k = 0; k < means.size(); ++k) {
    const Vector3 y = (means[k] - middle) / size;
    for (std::size_t i = 0; i < 3; ++i) design(k, i) = y[i] * y[i], design(k, 3 + i) = y[i];
  }
  const QrFit fit = qr_fit(design, std::vector<double>(means.size(), 1.0));
  if (fit.rank < 6) return {};
  const auto& c = fit.x;
  double radius = 1.0;  // 1 + sum q^2/(4 p) of the completed squares
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(c[i] > 0.0)) return {};
    radius += c[3 + i] * c[3 + i] / (4.0 * c[i]);
  }
  Linear out{.matrix = {}, .bias = {}};
  for (std::size_t i = 0; i < 3; ++i) {
    out.bias[i] = middle[i] - size * c[3 + i] / (2.0 * c[i]);
    out.matrix(i, i) = size * std::sqrt(radius / c[i]) / gravity;
  }
  return out;
}

/// 1 within three robust standard deviations, less beyond.
std::vector<double> robust_weights(const std::vector<double>& residual) {
  std::vector<double> size, weights;
  for (const double r : residual) size.push_back(std::abs(r));
  const double bound = outside_sd * sd_of_median_size * median(size);
  for (const double r : residual) weights.push_back(std::abs(r) <= bound ? 1.0 : bound * bound / (r * r));
  return weights;
}

/// The calibration that Gauss-Newton improves, with the matrix of its normal equations in coefficients / scale.
struct Search {
  const std::vector<Vector3>& means;
  double gravity, scale;
  Sphere sphere;
  Matrix normal{of_accelerometers, of_accelerometers};

  void find_residuals() {
    const Inverse input(sphere.accelerometer);
    for (std::size_t k = 0; k < means.size(); ++k) sphere.residual[k] = norm(input(means[k])) - gravity;
  }

  /// The next change of the coefficients. d|f| = -(M^-T f/|f|)' (dM f + db).
  std::vector<double> step() {
    const Inverse input(sphere.accelerometer);
    const Matrix3 transpose = transposed(input.matrix);
    const auto weights = robust_weights(sphere.residual);
    normal = Matrix(of_accelerometers, of_accelerometers);
    std::vector<double> right(of_accelerometers);
    for (std::size_t k = 0; k < means.size(); ++k) {
      const Vector3 f = input(means[k]);
      const Coefficients d = derivative(-scale * (transpose * normalised(f)), f);
      add_square(normal, weights[k], d);
      right = scaled_sum(right, -weights[k] * sphere.residual[k], d);
    }
    return scaled(scale, solve_symmetric(normal, right));
  }
};

/// Sizes of the coefficients relative to the scale factors: makes the determinant one of relative numbers.
Coefficients sizes(double gravity) { return {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, gravity, gravity, gravity}; }

bool iterate(Search& search) {
  const Coefficients size = sizes(search.gravity);
  search.find_residuals();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const auto step = search.step();
    bool small = true;
    for (std::size_t i = 0; i < step.size(); ++i) {
      if (!std::isfinite(step[i])) return false;
      small = small && std::abs(step[i]) < last_step * search.scale * size[i];
    }
    add(step, search.sphere.accelerometer);
    if (small) break;
    search.find_residuals();
  }
  return true;
}

}  // namespace

Box box_of(const std::vector<Vector3>& means) {
  constexpr double far = std::numeric_limits<double>::infinity();
  Box box{{far, far, far}, {-far, -far, -far}};
  for (const Vector3& mean : means)
    for (std::size_t i = 0; i < 3; ++i)
      box.low[i] = std::min(box.low[i], mean[i]), box.high[i] = std::max(box.high[i], mean[i]);
  return box;
}

Coefficients derivative(Vector3 v, Vector3 u) {
  return {v.x * u.x, v.y * u.x, v.y * u.y, v.z * u.x, v.z * u.y, v.z * u.z, v.x, v.y, v.z};
}

void add(std::span<const double> step, Linear& to) {
  to.matrix += Matrix3{{step[0], 0.0, 0.0}, {step[1], step[2], 0.0}, {step[3], step[4], step[5]}};
  to.bias += {step[6], step[7], step[8]};
}

std::optional<Sphere> fit_sphere(const std::vector<Vector3>& means, double gravity) {
  const auto start = ellipsoid(means, gravity);
  if (!start || means.size() < fewest_of_sphere) return {};
  Search search{means, gravity, greatest(diagonal_of(start->matrix)), {*start, std::vector<double>(means.size())}};
  if (!iterate(search)) return {};
  Sphere& out = search.sphere;
  const auto weights = robust_weights(out.residual);
  const double degrees = static_cast<double>(means.size() - of_accelerometers);
  out.scatter = std::sqrt(dot(weights, scaled(out.residual, out.residual)) / degrees);
  const Vector3 scale_factors = diagonal_of(out.accelerometer.matrix);
  if (!std::isfinite(out.scatter) || !(std::min({scale_factors.x, scale_factors.y, scale_factors.z}) > 0.0)) return {};
  const Coefficients size = sizes(gravity);
  const double relative = determinant(scaled_rows(size, scaled_columns(search.normal, size)));
  out.log_determinant = 9.0 * std::log(degrees / (degrees - 2.0)) +  // few degrees: the scatter itself is uncertain
                        18.0 * std::log(std::max(out.scatter, least_scatter * gravity)) -
                        std::log(std::max(relative, 1e-300));
  return out;
}

}  // namespace tumble::imu_multi_position
