#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/methods/imu_multi_position/describe.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu_multi_position {
namespace {

/// [rad] 26 deg about a direction: less than halfway to the next of a cube, 45 deg.
constexpr double near_direction = pi / 7.0;

/// Faces, edges, corners, in this order.
std::vector<Vector3> cube() {
  constexpr double of_digit[] = {0.0, 1.0, -1.0};
  std::vector<Vector3> all;
  for (int axes = 1; axes <= 3; ++axes)
    for (int code = 0; code < 27; ++code) {
      const Vector3 v{of_digit[code % 3], of_digit[code / 3 % 3], of_digit[code / 9]};
      if (static_cast<int>(dot(v, v)) == axes) all.push_back(normalised(v));
    }
  return all;
}

std::string named(Vector3 v) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(v[i]) > rounding_share)
      text += fmt::format("{}{}{}", text.empty() ? "" : " ", v[i] < 0.0 ? '-' : '+', letters[i]);
  return text;
}

std::size_t nearest(const std::vector<Vector3>& all, Vector3 up) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (dot(all[i], up) > dot(all[best], up)) best = i;
  return best;
}

/// 1 + rows covariance rows', of whitened rows that a new observation adds.
Matrix innovation(const Matrix& covariance, const Matrix& rows) {
  return identity(rows.rows) + sandwich(rows, covariance);
}

Matrix with(const Matrix& covariance, const Matrix& rows) {
  return covariance - sandwich(covariance * transposed(rows), inverse(innovation(covariance, rows)));
}

/// Logarithm of the determinant gained, by which observations are compared.
double worth(const Matrix& covariance, const Matrix& rows) {
  return std::log(determinant(innovation(covariance, rows)));
}

/// A rest like the others with that direction up.
Matrix rest_towards(const Fit& fit, Vector3 up, double gravity, Vector3 variance) {
  const Vector3 v = -(transposed(inverse(fit.calibration.accelerometer.matrix)) * up);
  const double sd = std::sqrt(dot(scaled(v, v), variance));
  Matrix row(1, fit.parameters);
  std::ranges::copy(scaled(1.0 / sd, derivative(v, gravity * up)), row.values.begin());
  return row;
}

/// A turn by 90 deg about a level axis.
Matrix turn_about(const Fit& fit, Vector3 axis, double variance) {
  const double angle = half_pi;
  constexpr int steps = 16;
  Matrix3 sum;
  for (int i = 0; i < steps; ++i) sum += (angle / steps) * matrix3(about(axis, -angle * (i + 0.5) / steps));
  const Matrix3 transpose = transposed(sum * inverse(fit.calibration.gyro.matrix));
  const Vector3 across[] = {axis, cross(unit_across(axis), axis)};  // directions in which a small turn moves `up`
  Matrix rows(2, fit.parameters);
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t i = 0; i < 3; ++i)
        rows(r, gyro_index(i, j)) = axis[j] * (transpose * across[r])[i] / std::sqrt(variance);
  return rows;
}

struct Gain {
  double share = 0.0;  ///< of the sd, 0 to 1
  std::string of;
};

Gain gain_of(const Matrix& before, const Matrix& after, const std::vector<std::string>& names) {
  Gain gain;
  for (std::size_t i = 0; i < before.rows; ++i) {
    const double share = 1.0 - std::sqrt(std::max(after(i, i), 0.0) / before(i, i));
    if (share > gain.share + rounding_share) gain = {share, names[i]};
  }
  gain.share = std::round(1e3 * gain.share) / 1e3;  // a tenth of a percent is more than anybody needs
  return gain;
}

Vector3 variance_of_rest(const Fit& fit) {
  Vector3 sum;
  double n = 0.0;
  for (const Group& group : fit.groups) {
    if (group.part != Part::force || !group.used) continue;
    for (std::size_t i = 0; i < 3; ++i) sum[i] += group.rows[i].white + fit.scatter[0] * group.rows[i].unit;
    n += 1.0;
  }
  return sum / std::max(n, 1.0);
}

double variance_of_turn(const Fit& fit, double gravity) {
  const Vector3 rest = variance_of_rest(fit), scale = gravity * diagonal_of(fit.calibration.accelerometer.matrix);
  double ends = 0.0, noise = 0.0, n = 0.0;
  for (std::size_t i = 0; i < 3; ++i) ends += 2.0 * rest[i] / (scale[i] * scale[i]) / 3.0;
  for (const Group& group : fit.groups)
    if (group.part == Part::turn && group.used) noise += group.rows[0].white + group.rows[0].earth, n += 1.0;
  return noise / std::max(n, 1.0) + fit.scatter[2] * half_pi * half_pi + ends;
}

/// Rests that could be added: all directions of a cube.
struct Candidates {
  std::vector<Vector3> up;
  std::vector<Matrix> rows;  ///< [1 x parameters] each
};

Candidates candidates_of(const Fit& fit, double gravity) {
  Candidates out{cube(), {}};
  const Vector3 variance = variance_of_rest(fit);
  for (const Vector3& up : out.up) out.rows.push_back(rest_towards(fit, up, gravity, variance));
  return out;
}

void add_poses(const Fit& fit, const std::vector<std::string>& names, double gravity, Guidance& out) {
  const Candidates poses = candidates_of(fit, gravity);
  std::vector<double> rests(poses.up.size(), 0.0);
  for (const Vector3& up : fit.direction) rests[nearest(poses.up, up)] += 1.0;
  std::vector<Gain> gains;
  for (const Matrix& row : poses.rows) gains.push_back(gain_of(fit.covariance, with(fit.covariance, row), names));
  out.poses =
      tabulate("poses", "rests by direction up, and the reduction of a standard uncertainty by one more rest there",
               poses.up.size(),
               {{"up", [&](std::size_t i) { return named(poses.up[i]); }},
                {"rests", [&](std::size_t i) { return rests[i]; }},
                {"gain", "%", [&](std::size_t i) { return gains[i].share; }},
                {"of", [&](std::size_t i) { return gains[i].of; }}});
  Matrix covariance = fit.covariance;
  std::vector<std::string> chosen;
  for (int pick = 0; pick < 3; ++pick) {
    std::size_t best = 0;
    double most = -1.0;
    for (std::size_t i = 0; i < poses.up.size(); ++i) {
      const double value = worth(covariance, poses.rows[i]);
      if (value > most * (1.0 + rounding_share)) best = i, most = value;
    }
    chosen.push_back(named(poses.up[best]));
    covariance = with(covariance, poses.rows[best]);
  }
  const Gain gain = gain_of(fit.covariance, covariance, names);
  out.advice.push_back({Finding::Severity::info,
                        "more_rests_advised",
                        {{"first", chosen[0]},
                         {"second", chosen[1]},
                         {"third", chosen[2]},
                         {"gain", gain.share, "%"},
                         {"parameter", gain.of}}});
}

void add_turns(const Fit& fit, const std::vector<std::string>& names, double gravity, Guidance& out) {
  if (fit.parameters == of_accelerometers) return;
  const double variance = variance_of_turn(fit, gravity);
  const auto axis = [](std::size_t i) { return std::string(1, letters[i]); };
  const auto turned = [&](std::size_t i) {
    double sum = 0.0;
    for (const Group& group : fit.groups)
      if (group.part == Part::turn && group.used) sum += fit.turns[group.index].about[i];
    return sum;
  };
  std::vector<Gain> gains;
  std::size_t best = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    gains.push_back(gain_of(fit.covariance, with(fit.covariance, turn_about(fit, identity3()[i], variance)), names));
    if (gains[i].share > gains[best].share) best = i;
  }
  out.turns = tabulate("turns",
                       "angle turned about each axis, and the reduction of a standard uncertainty by one more turn of "
                       "90 deg about it, held level",
                       gains.size(),
                       {{"axis", axis},
                        {"turned", "deg", turned},
                        {"gain", "%", [&](std::size_t i) { return gains[i].share; }},
                        {"of", [&](std::size_t i) { return gains[i].of; }}});
  if (gains[best].share > 0.0)
    out.advice.push_back({Finding::Severity::info,
                          "more_turns_advised",
                          {{"axis", axis(best)}, {"gain", gains[best].share, "%"}, {"parameter", gains[best].of}}});
}

}  // namespace

std::string facing(Vector3 up) {
  static const auto all = cube();
  return named(all[nearest(all, up)]);
}

Guidance guidance_of(const Fit& fit, const std::vector<std::string>& names, double gravity) {
  Guidance out;
  add_poses(fit, names, gravity, out);
  add_turns(fit, names, gravity, out);
  return out;
}

std::string missing(const std::vector<Vector3>& directions) {
  const auto all = cube();
  std::string list;
  int listed = 0;
  for (std::size_t i = 0; i < 18 && listed < 9; ++i)
    if (std::ranges::none_of(directions, [&](Vector3 up) { return dot(up, all[i]) > std::cos(near_direction); }))
      list += (listed++ > 0 ? ", " : "") + named(all[i]);
  return list;
}

}  // namespace tumble::imu_multi_position
