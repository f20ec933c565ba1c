#include "tumble/methods/imu_ferraris/uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/earth/earth.hpp"
#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/reduce/imu/sensors.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_ferraris {
namespace {

using imu::component;
constexpr double infinite = std::numeric_limits<double>::infinity();

Vector3 unit_vector(std::size_t axis) { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }
Vector3 times(const Matrix& m, Vector3 v) {
  return {m(0, 0) * v.x + m(0, 1) * v.y + m(0, 2) * v.z, m(1, 0) * v.x + m(1, 1) * v.y + m(1, 2) * v.z,
          m(2, 0) * v.x + m(2, 1) * v.y + m(2, 2) * v.z};
}
void add(Vector3& v, std::size_t axis, double amount) { (axis == 0 ? v.x : axis == 1 ? v.y : v.z) += amount; }

/// Change of the unit vector along `axis` when it leans by these small angles toward the two others.
Vector3 lean(std::size_t axis, double first, double second) {
  const Vector3 leaning =
      unit_vector(axis) + first * unit_vector((axis + 1) % 3) + second * unit_vector((axis + 2) % 3);
  return (1.0 / norm(leaning)) * leaning - unit_vector(axis);
}

/// Variance of the mean of output k in a section.
double variance(const Recorded& recorded, std::size_t section, std::size_t k) {
  const auto& s = recorded.section[section];
  return s.density[k] / static_cast<double>(s.samples);
}

Cause accelerometer_noise(const Recorded& recorded) {
  Cause cause{"noise of the accelerometers", {}, 0.0, nullptr};
  for (std::size_t p = 0; p < poses; ++p) {
    for (std::size_t k = 0; k < 3; ++k) cause.sd.push_back(std::sqrt(variance(recorded, p, k)));
    cause.freedom += recorded.section[p].freedom[0];
  }
  cause.disturb = [](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p)
      for (std::size_t k = 0; k < 3; ++k) add(disturbed.force[p], k, z[3 * p + k]);
  };
  return cause;
}

/// Variance of the gyros' means over what their noise within the sections explains: the means of the two poses of each
/// axis agree but for noise and drift from section to section. Six degrees of freedom.
double excess(const Means& means, const Recorded& recorded) {
  double ratio = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<double, 3> pair{};
    double noise = 0.0, squares = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      pair[axis] = 0.5 * (component(means.rate[2 * axis], k) + component(means.rate[2 * axis + 1], k));
      noise += 0.25 * (variance(recorded, 2 * axis, 3 + k) + variance(recorded, 2 * axis + 1, 3 + k)) / 3.0;
    }
    const double mean = (pair[0] + pair[1] + pair[2]) / 3.0;
    for (const double one : pair) squares += (one - mean) * (one - mean) / 2.0;
    if (noise > 0.0) ratio += squares / noise / 3.0;
  }
  return ratio;
}

Cause gyro_noise(const Means& means, const Recorded& recorded) {
  Cause cause{"noise and drift of the gyros", {}, 6.0, nullptr};
  const double larger = excess(means, recorded);
  for (std::size_t p = 0; p < poses; ++p)
    for (std::size_t k = 3; k < outputs; ++k) cause.sd.push_back(std::sqrt(larger * variance(recorded, p, k)));
  for (std::size_t t = 0; t < turns; ++t)
    for (std::size_t k = 3; k < outputs; ++k) {  // as at rest: in a turn the noise cannot be told from the motion
      double density = 0.0;
      for (std::size_t p = 0; p < poses; ++p) density += recorded.section[p].density[k] / poses;
      const auto samples = static_cast<double>(recorded.section[poses + t].samples);
      cause.sd.push_back(means.turn_time[t] * std::sqrt(larger * density / samples));
    }
  cause.disturb = [](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p)
      for (std::size_t k = 0; k < 3; ++k) add(disturbed.rate[p], k, z[3 * p + k]);
    for (std::size_t t = 0; t < turns; ++t)
      for (std::size_t k = 0; k < 3; ++k) add(disturbed.turned[t], k, z[3 * (poses + t) + k]);
  };
  return cause;
}

Cause tilts_of(const Calibration& c, const Squareness& square) {
  const Matrix force = response(c.k_a, c.r_a);
  return {"orientation of the poses", std::vector<double>(2 * poses, square.sd), square.freedom,
          [force, sensitivity = c.k_ga](std::span<const double> z, Means& means) {
            for (std::size_t p = 0; p < poses; ++p) {
              const Vector3 change = sign_of(p) * means.gravity * lean(axis_of(p), z[2 * p], z[2 * p + 1]);
              means.force[p] = means.force[p] + times(force, change);
              if (means.gyros) means.rate[p] = means.rate[p] + times(sensitivity, change);
            }
          },
          true};
}

Cause gravity_cause(double sd) {
  return {"gravity", {sd}, infinite, [](std::span<const double> z, Means& means) { means.gravity += z[0]; }};
}

Cause axes_of(const Calibration& c, double sd, double freedom) {
  return {"axes of the turns", std::vector<double>(2 * turns, sd), freedom,
          [rate = response(c.k_g, c.r_g)](std::span<const double> z, Means& means) {
            for (std::size_t t = 0; t < turns; ++t)
              means.turned[t] = means.turned[t] + means.angle[t] * times(rate, lean(t, z[2 * t], z[2 * t + 1]));
          },
          true};
}

Cause angles_of(double sd) {
  return {"angle of the turns", std::vector<double>(turns, sd), infinite, [](std::span<const double> z, Means& means) {
            for (std::size_t t = 0; t < turns; ++t) means.angle[t] += z[t];
          }};
}

/// The Earth's rate is in every output: along the vertical with the sign of the pose, and level in unknown directions.
Cause earth_of(const Plan& plan, const Calibration& c, const Means& means) {
  const double whole = earth_rate / std::sqrt(3.0);
  double vertical = whole, level = whole;
  if (plan.site) {
    vertical = std::abs(earth_rate * std::sin(plan.site->latitude));
    level = earth_rate * std::cos(plan.site->latitude) / std::sqrt(2.0);
  }
  Cause cause{"Earth rate", {vertical}, infinite, nullptr};
  cause.sd.insert(cause.sd.end(), 2 * poses, level);
  for (std::size_t t = 0; t < turns; ++t) cause.sd.insert(cause.sd.end(), 3, whole * means.turn_time[t]);
  cause.disturb = [rate = response(c.k_g, c.r_g)](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p) {
      const std::size_t axis = axis_of(p);
      const Vector3 felt = sign_of(p) * z[0] * unit_vector(axis) + z[1 + 2 * p] * unit_vector((axis + 1) % 3) +
                           z[2 + 2 * p] * unit_vector((axis + 2) % 3);
      disturbed.rate[p] = disturbed.rate[p] + times(rate, felt);
    }
    for (std::size_t t = 0; t < turns; ++t) {
      const double* turn = z.data() + 1 + 2 * poses + 3 * t;
      disturbed.turned[t] = disturbed.turned[t] + times(rate, {turn[0], turn[1], turn[2]});
    }
  };
  return cause;
}

/// F of the noise alone, beyond which something else is seen: one time in a hundred by chance.
double by_chance(double freedom) { return chi_square_quantile(0.99, freedom) / freedom; }

double degrees(double angle) { return Unit::parse("deg").from_si(angle); }

/// The tilt stated, held against the one seen; or the one seen.
Squareness agreed(const Plan& plan, const Squareness& seen, Findings& findings) {
  const auto& settings = plan.settings;
  if (!settings.has("pose_sd")) {
    findings.push_back(
        {Finding::Severity::info,
         seen.sd > 0.0 ? fmt::format("the poses are laid to {:.2g} deg (sd of each tilt), as their means show; what "
                                     "all poses have in common, as faces that are not square, they do not show",
                                     degrees(seen.sd))
                       : "the poses are laid as squarely as the noise lets see; what all poses have in common, as "
                         "faces that are not square, they do not show",
         ""});
    return seen;
  }
  const double sd = settings.number("pose_sd");
  if (seen.sd > 0.0 && seen.sd * seen.sd > by_chance(6.0) * sd * sd)
    findings.push_back(
        {Finding::Severity::warning,
         fmt::format("the poses are laid to {:.2g} deg, as their means show, not to pose_sd = {:.2g} deg: "
                     "state more, or leave pose_sd out",
                     degrees(seen.sd), degrees(sd)),
         ""});
  return {sd, infinite};
}

}  // namespace

Known gravity_of(const Plan& plan) {
  constexpr double ug = micro_g;
  Known known;
  const auto& settings = plan.settings;
  if (settings.has("gravity"))
    known = {settings.number("gravity"), 100.0 * ug, "as set"};
  else if (plan.site && plan.site->gravity)
    known = {gravity(*plan.site), 5.0 * ug, "of the site, as measured"};
  else if (plan.site)
    known = {gravity(*plan.site), 50.0 * ug, "of the site, by the normal formula"};
  else
    known = {standard_gravity, 0.015, "unknown: the standard value, and the range over the Earth as its uncertainty"};
  if (settings.has("gravity_sd")) known.sd = settings.number("gravity_sd");
  if (!(known.value > 0.0)) throw Error(Error::Kind::bad_input, "gravity must be above zero");
  return known;
}

Squareness squareness(const Means& means, const Calibration& calibration, const Recorded& recorded) {
  double squares = 0.0, noise = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double g = component(calibration.k_a, k) * means.gravity;
    const double own = variance(recorded, 2 * k, k) + variance(recorded, 2 * k + 1, k);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == k) continue;
      const double sum = component(means.force[2 * axis], k) + component(means.force[2 * axis + 1], k);
      const double across = (0.5 * sum - component(calibration.b_a, k)) / g;
      squares += across * across / 6.0;
      noise += 0.25 * (own + variance(recorded, 2 * axis, k) + variance(recorded, 2 * axis + 1, k)) / (g * g) / 6.0;
    }
  }
  if (squares <= noise) return {0.0, infinite};
  const double share = 1.0 - noise / squares;  // so that tilts and noise together have six degrees of freedom
  return {std::sqrt(2.0 * (squares - noise)), 6.0 * share * share};
}

std::vector<Cause> causes(const Plan& plan, const Means& means, const Calibration& calibration,
                          const Recorded& recorded, Findings& findings) {
  const auto& settings = plan.settings;
  const Squareness square = agreed(plan, squareness(means, calibration, recorded), findings);
  std::vector<Cause> all{accelerometer_noise(recorded), tilts_of(calibration, square),
                         gravity_cause(gravity_of(plan).sd)};
  if (!means.gyros) return all;
  all.push_back(gyro_noise(means, recorded));
  const bool stated = settings.has("rotation_axis_sd");
  all.push_back(axes_of(calibration, stated ? settings.number("rotation_axis_sd") : square.sd,
                        stated ? infinite : square.freedom));
  all.push_back(angles_of(settings.number("rotation_angle_sd")));
  all.push_back(earth_of(plan, calibration, means));
  return all;
}

Matrix second_moments(const Cause& cause, const Means& means) {
  std::vector<double> z(cause.sd.size(), 0.0);
  const auto at_z = [&] {
    Means disturbed = means;
    cause.disturb(z, disturbed);
    const auto p = parameters_of(closed_form(disturbed));
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(p.data(), at(p.size())));
  };
  const Eigen::VectorXd middle = at_z();
  const auto n = cause.sd.size();
  Eigen::MatrixXd slope(middle.size(), at(n));  // times sd
  std::vector<Eigen::VectorXd> plus(n), minus(n);
  for (std::size_t i = 0; i < n; ++i) {
    z[i] = cause.sd[i];
    plus[i] = at_z();
    z[i] = -cause.sd[i];
    minus[i] = at_z();
    z[i] = 0.0;
    slope.col(at(i)) = 0.5 * (plus[i] - minus[i]);
  }
  Eigen::MatrixXd moments = slope * slope.transpose();
  if (cause.curved) {
    Eigen::VectorXd trace = Eigen::VectorXd::Zero(middle.size());
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::VectorXd own = plus[i] + minus[i] - 2.0 * middle;
      trace += own;
      moments += 0.5 * own * own.transpose();
      for (std::size_t j = 0; j < i; ++j) {
        z[i] = cause.sd[i];
        z[j] = cause.sd[j];
        const Eigen::VectorXd mixed = at_z() - plus[i] - plus[j] + middle;
        z[i] = z[j] = 0.0;
        moments += mixed * mixed.transpose();
      }
    }
    moments += 0.25 * trace * trace.transpose();
  }
  return plain(moments);
}

}  // namespace tumble::imu_ferraris
