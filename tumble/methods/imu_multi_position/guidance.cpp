#include "tumble/methods/imu_multi_position/guidance.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble::imu_multi_position {
namespace {

/// Faces, edges, corners, in this order.
std::vector<Vector3d> cube() {
  std::vector<Vector3d> all;
  for (int parts = 1; parts <= 3; ++parts)
    for (int code = 0; code < 27; ++code) {
      const Vector3d v(code % 3 == 1   ? 1.0
                       : code % 3 == 2 ? -1.0
                                       : 0.0,
                       code / 3 % 3 == 1   ? 1.0
                       : code / 3 % 3 == 2 ? -1.0
                                           : 0.0,
                       code / 9 == 1   ? 1.0
                       : code / 9 == 2 ? -1.0
                                       : 0.0);
      if (static_cast<int>(v.cwiseAbs().sum()) == parts) all.push_back(v.normalized());
    }
  return all;
}

std::string named(const Vector3d& v) {
  std::string text;
  for (int i = 0; i < 3; ++i)
    if (std::abs(v[i]) > 1e-9)
      text +=
          fmt::format("{}{}{}", text.empty() ? "" : " ", v[i] < 0.0 ? '-' : '+', letters[static_cast<std::size_t>(i)]);
  return text;
}

std::size_t nearest(const std::vector<Vector3d>& all, const Vector3d& up) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].dot(up) > all[best].dot(up)) best = i;
  return best;
}

/// Rows that a new observation adds, whitened.
using Rows = Eigen::MatrixXd;

Eigen::MatrixXd with(const Eigen::MatrixXd& covariance, const Rows& rows) {
  const Eigen::MatrixXd cross = covariance * rows.transpose();
  const Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(rows.rows(), rows.rows()) + rows * cross;
  return covariance - cross * inner.inverse() * cross.transpose();
}

/// log of the determinant gained: what tells observations apart.
double worth(const Eigen::MatrixXd& covariance, const Rows& rows) {
  const Eigen::MatrixXd inner =
      Eigen::MatrixXd::Identity(rows.rows(), rows.rows()) + rows * covariance * rows.transpose();
  return std::log(inner.determinant());
}

/// A rest like the others with that direction up.
Rows rest_towards(const Fit& fit, const Vector3d& up, double gravity, const Vector3d& variance) {
  const auto& linear = fit.calibration.accelerometer;
  const Vector3d v = -linear.matrix.inverse().transpose() * up, f = gravity * up;
  Rows rows = Rows::Zero(1, fit.parameters);
  rows.leftCols<9>() << v[0] * f[0], v[1] * f[0], v[1] * f[1], v[2] * f[0], v[2] * f[1], v[2] * f[2], v.transpose();
  return rows / std::sqrt(v.cwiseAbs2().dot(variance));
}

/// A turn by 90 deg about a level axis.
Rows turn_about(const Fit& fit, const Vector3d& axis, double variance) {
  const double angle = half_pi;
  const Vector3d up = axis.unitOrthogonal();
  const Matrix3d inverse = fit.calibration.gyro.matrix.inverse();
  Matrix3d sum = Matrix3d::Zero();
  constexpr int steps = 16;
  for (int i = 0; i < steps; ++i)
    sum += Eigen::AngleAxisd(angle * (i + 0.5) / steps, axis).toRotationMatrix() * (angle / steps);
  Rows rows = Rows::Zero(2, fit.parameters);
  Eigen::Matrix<double, 2, 3> across;
  across << axis.transpose(), up.cross(axis).transpose();  // what a small turn moves `up` by, across it
  for (int j = 0; j < 3; ++j)
    rows.middleCols<3>(gyro_index(0, j)) = across * axis[j] * sum * inverse / std::sqrt(variance);
  return rows;
}

struct Gain {
  double share = 0.0;  ///< of the sd, 0 to 1
  std::string of;
};

Gain gain_of(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after, const std::vector<std::string>& names) {
  Gain gain;
  for (Eigen::Index i = 0; i < before.rows(); ++i) {
    const double share = 1.0 - std::sqrt(std::max(after(i, i), 0.0) / before(i, i));
    if (share > gain.share + 1e-9) gain = {share, names[static_cast<std::size_t>(i)]};
  }
  gain.share = std::round(1e3 * gain.share) / 1e3;  // a tenth of a percent is more than anybody needs
  return gain;
}

Vector3d variance_of_rest(const Fit& fit) {
  Vector3d sum = Vector3d::Zero();
  double n = 0.0;
  for (const Group& group : fit.groups)
    if (group.part == Part::force && group.used) sum += group.white + fit.scatter[0] * group.unit, n += 1.0;
  return sum / std::max(n, 1.0);
}

double variance_of_turn(const Fit& fit, double gravity) {
  const Vector3d ends =
      variance_of_rest(fit).cwiseQuotient(fit.calibration.accelerometer.matrix.diagonal().cwiseAbs2());
  double noise = 0.0, n = 0.0;
  for (const Group& group : fit.groups)
    if (group.part == Part::turn && group.used) noise += (group.white + group.earth).mean(), n += 1.0;
  return noise / std::max(n, 1.0) + fit.scatter[2] * std::pow(half_pi, 2) + 2.0 * ends.mean() / (gravity * gravity);
}

void add_poses(const Fit& fit, const std::vector<std::string>& names, double gravity, Guidance& out) {
  const auto all = cube();
  const Vector3d variance = variance_of_rest(fit);
  std::vector<double> rests(all.size(), 0.0);
  for (const auto& up : fit.direction) rests[nearest(all, up)] += 1.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Gain gain =
        gain_of(fit.covariance, with(fit.covariance, rest_towards(fit, all[i], gravity, variance)), names);
    out.poses.rows.push_back({named(all[i]), rests[i], gain.share, gain.of});
  }
  Eigen::MatrixXd covariance = fit.covariance;
  std::string list;
  for (int pick = 0; pick < 3; ++pick) {
    std::size_t best = 0;
    double most = -1.0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double value = worth(covariance, rest_towards(fit, all[i], gravity, variance));
      if (value > most * (1.0 + 1e-9)) best = i, most = value;
    }
    list += fmt::format("{}{}", list.empty() ? "" : pick == 2 ? " and then " : ", ", named(all[best]));
    covariance = with(covariance, rest_towards(fit, all[best], gravity, variance));
  }
  const Gain gain = gain_of(fit.covariance, covariance, names);
  out.advice = fmt::format("three more rests would do most with {} up: up to {:.0f} % off the uncertainty ({})", list,
                           100.0 * gain.share, gain.of);
}

void add_turns(const Fit& fit, const std::vector<std::string>& names, double gravity, Guidance& out) {
  if (fit.parameters == of_accelerometers) return;
  const double variance = variance_of_turn(fit, gravity);
  Gain best;
  std::string axis;
  for (int i = 0; i < 3; ++i) {
    double turned = 0.0;
    for (const Group& group : fit.groups)
      if (group.part == Part::turn && group.used) turned += fit.turns[group.index].about[i];
    const Gain gain =
        gain_of(fit.covariance, with(fit.covariance, turn_about(fit, Vector3d::Unit(i), variance)), names);
    const std::string name(1, letters[static_cast<std::size_t>(i)]);
    if (gain.share > best.share) best = gain, axis = name;
    out.turns.rows.push_back({name, turned, gain.share, gain.of});
  }
  if (best.share > 0.0)
    out.advice += fmt::format("; one more turn by 90 deg would do most about {} held level: {:.0f} % ({})", axis,
                              100.0 * best.share, best.of);
}

}  // namespace

std::string facing(const Vector3d& up) {
  static const auto all = cube();
  return named(all[nearest(all, up)]);
}

Guidance guidance_of(const Fit& fit, const std::vector<std::string>& names, double gravity) {
  const Unit percent = Unit::parse("%"), one = Unit::parse("1");
  Guidance out;
  out.poses = {"poses",
               "rests by what points up, and what one more there would take off a standard uncertainty",
               {{"up", one}, {"rests", one}, {"gain", percent}, {"of", one}},
               {},
               false};
  out.turns = {"turns",
               "angle turned about each axis, and what one more turn by 90 deg about it, held level, would take off",
               {{"axis", one}, {"turned", Unit::parse("deg")}, {"gain", percent}, {"of", one}},
               {},
               false};
  add_poses(fit, names, gravity, out);
  add_turns(fit, names, gravity, out);
  return out;
}

std::string missing(const std::vector<Vector3d>& directions) {
  const auto all = cube();
  std::string list;
  int listed = 0;
  for (std::size_t i = 0; i < 18 && listed < 9; ++i) {
    const bool seen = std::any_of(directions.begin(), directions.end(),
                                  [&](const Vector3d& up) { return up.dot(all[i]) > std::cos(pi / 7.0); });
    if (!seen) list += (listed++ > 0 ? ", " : "") + named(all[i]);
  }
  return list;
}

}  // namespace tumble::imu_multi_position
