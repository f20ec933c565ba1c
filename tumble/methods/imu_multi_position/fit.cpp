#include "tumble/methods/imu_multi_position/fit.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/imu_multi_position/faults.hpp"
#include "tumble/methods/imu_multi_position/variance.hpp"

namespace tumble::imu_multi_position {
namespace {

using Basis = Eigen::Matrix<double, 3, 2>;

/// Two directions across n.
Basis across(const Vector3d& n) {
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  Basis b;
  b.col(0) = n.cross(Vector3d::Unit(least)).normalized();
  b.col(1) = n.cross(b.col(0));
  return b;
}

struct Work {
  const std::vector<Session>& sessions;
  Rests& rests;
  const FitOptions& options;
  Fit& fit;
};

constexpr double floor_of_noise = 1e-10;  ///< relative; for data without any

void set_rest(const Work& work, Group& group) {
  const Fit& fit = work.fit;
  const Rest& rest = work.rests.all[group.index];
  const Linear& linear = fit.calibration.accelerometer;
  const Vector3d force = work.options.gravity * fit.direction[group.pair];
  const double length = rest.end - rest.begin;
  group.residual = rest.force - linear.matrix * force - linear.bias;
  group.common.setZero(3, 9);
  group.common(0, 0) = force[0];
  group.common(1, 1) = force[0], group.common(1, 2) = force[1];
  group.common(2, 3) = force[0], group.common(2, 4) = force[1], group.common(2, 5) = force[2];
  group.common.rightCols<3>() = Matrix3d::Identity();
  group.here = work.options.gravity * linear.matrix * across(fit.direction[group.pair]);
  group.unit = linear.matrix.diagonal().cwiseAbs2();
  group.white = work.rests.noise.force / length + std::pow(floor_of_noise * work.options.gravity, 2) * group.unit;
  group.earth.setZero(3);
}

/// The Earth's rate about the vertical, and the sd of what is not known of it about each axis.
double earth_up(const FitOptions& options) { return options.latitude ? earth_rate * std::sin(*options.latitude) : 0.0; }
double earth_sd(const FitOptions& options) {
  return options.latitude ? earth_rate * std::cos(*options.latitude) / std::sqrt(2.0) : earth_rate / std::sqrt(3.0);
}

/// What the Earth's rotation is in the axes of a rest; `known`: by the moves since the first one.
Vector3d earth_at(const Work& work, std::size_t pair, bool& known) {
  const auto& from_first = work.fit.from_first[pair];
  known = from_first.has_value();
  return known ? Vector3d(*from_first * work.fit.earth) : Vector3d(earth_up(work.options) * work.fit.direction[pair]);
}

void set_rate(const Work& work, Group& group) {
  const Fit& fit = work.fit;
  const Rest& rest = work.rests.all[group.index];
  const Calibration& c = fit.calibration;
  const Vector3d n = fit.direction[group.pair];
  bool known = false;
  const Vector3d earth = earth_at(work, group.pair, known);
  group.first = 9;
  group.residual = rest.rate - c.gyro.bias - work.options.gravity * c.sensitivity * n - c.gyro.matrix * earth;
  group.common.setZero(3, fit.unknowns() - 9);
  for (int j = 0; j < 3; ++j) {
    group.common.middleCols<3>(3 * j) = earth[j] * Matrix3d::Identity();
    if (fit.parameters == with_sensitivity)
      group.common.middleCols<3>(12 + 3 * j) = work.options.gravity * n[j] * Matrix3d::Identity();
  }
  group.common.middleCols<3>(9) = Matrix3d::Identity();
  if (known) group.common.rightCols<3>() = c.gyro.matrix * *fit.from_first[group.pair];
  group.here = work.options.gravity * c.sensitivity * across(n);
  group.unit = c.gyro.matrix.rowwise().squaredNorm();
  group.white = work.rests.noise.rate / (rest.end - rest.begin) + floor_of_noise * floor_of_noise * group.unit;
  group.earth = (known ? 0.0 : std::pow(earth_sd(work.options), 2)) * group.unit;
}

void set_turn(const Work& work, Group& group) {
  Fit& fit = work.fit;
  const Move& move = fit.moves[group.index];
  Turn& turn = fit.turns[group.index];
  const Matrix3d inverse = fit.calibration.gyro.matrix.inverse();
  bool known = false;
  const Vector3d earth = earth_at(work, group.pair, known);
  turn = turn_of(work.sessions[work.rests.all[move.from].session].gyro, move, fit.calibration, earth);
  fit.from_first[group.pair + 1].reset();
  if (known && group.used) fit.from_first[group.pair + 1] = turn.rotation.transpose() * *fit.from_first[group.pair];
  const Vector3d n = fit.direction[group.pair];
  const Basis after = across(fit.direction[group.pair + 1]);
  const Eigen::Matrix<double, 2, 3> project = after.transpose() * turn.rotation.transpose();
  group.first = 9;
  group.residual = -project * n;
  Matrix3d cross;  // n x
  cross << 0.0, -n[2], n[1], n[2], 0.0, -n[0], -n[1], n[0], 0.0;
  group.common.setZero(2, fit.unknowns() - 9);
  const int columns = fit.parameters == with_sensitivity ? 7 : 4;
  for (int j = 0; j < columns; ++j)
    group.common.middleCols<3>(3 * j) = -project * cross * turn.turned[static_cast<std::size_t>(j)] * inverse;
  if (known) group.common.rightCols<3>() = -move.duration * project * cross * *fit.from_first[group.pair];
  group.here = project * across(n);
  group.next = -Eigen::Matrix2d::Identity();
  const double density = (inverse.cwiseAbs2() * work.rests.noise.rate).mean();
  group.white.setConstant(2, density * move.duration + floor_of_noise * floor_of_noise);
  group.earth.setConstant(2, known ? 0.0 : std::pow(earth_sd(work.options) * move.duration, 2));
  group.unit.setConstant(2, std::max(turn.path * turn.path, 1e-4));
}

/// What is known of the Earth's rotation before: how far about the vertical of the first rest, and its size.
void set_earth(const Work& work, Group& group) {
  const Fit& fit = work.fit;
  Matrix3d axes;
  axes << fit.direction[0].transpose(), across(fit.direction[0]).transpose();
  group.first = fit.parameters;
  group.common = axes;
  group.residual = earth_up(work.options) * Vector3d::UnitX() - axes * fit.earth;
  group.here.setZero(3, 2);
  group.white.setZero(3), group.unit.setZero(3);
  group.earth.setConstant(3, std::pow(earth_sd(work.options), 2));
  if (work.options.latitude) group.earth[0] = std::pow(1e-3 * earth_rate, 2);
}

/// Moves come first: they say how the axes of the rests lie to one another.
void linearise(const Work& work) {
  for (Group& group : work.fit.groups)
    if (group.part == Part::turn) set_turn(work, group);
  for (Group& group : work.fit.groups) {
    if (group.part == Part::force) set_rest(work, group);
    if (group.part == Part::rate) set_rate(work, group);
    if (group.part == Part::earth) set_earth(work, group);
  }
}

void apply(const ChainSolution& step, Fit& fit) {
  const auto& p = step.parameters;
  auto& a = fit.calibration.accelerometer;
  a.matrix(0, 0) += p[0];
  a.matrix(1, 0) += p[1], a.matrix(1, 1) += p[2];
  a.matrix(2, 0) += p[3], a.matrix(2, 1) += p[4], a.matrix(2, 2) += p[5];
  a.bias += p.segment<3>(6);
  if (fit.parameters > of_accelerometers) {
    for (int j = 0; j < 3; ++j) fit.calibration.gyro.matrix.col(j) += p.segment<3>(gyro_index(0, j));
    fit.calibration.gyro.bias += p.segment<3>(gyro_index(0, 3));
  }
  if (fit.parameters == with_sensitivity)
    for (int j = 0; j < 3; ++j) fit.calibration.sensitivity.col(j) += p.segment<3>(gyro_index(0, 4 + j));
  if (fit.parameters > of_accelerometers) fit.earth += p.tail<3>();
  for (std::size_t k = 0; k < fit.direction.size(); ++k)
    fit.direction[k] = (fit.direction[k] + across(fit.direction[k]) * step.pairs[k]).normalized();
}

constexpr double roughly = 1e-2, finely = 1e-4;  ///< of a standard deviation

/// Gauss-Newton steps until one would change all by less than that, or `most`.
void iterate(const Work& work, int most, double close) {
  for (int i = 0; i < most; ++i) {
    const ChainSolution step = solve(normal_equations(work.fit), true);
    if (!step.sound) throw_singular();
    const auto relative = step.parameters.cwiseAbs2().cwiseQuotient(step.covariance.diagonal());
    if (relative.maxCoeff() < close * close) break;
    apply(step, work.fit);
    linearise(work);
  }
}

/// Bias and, where sought, G from the means at rest; single bad ones weigh little.
void start_rates(const Work& work) {
  Fit& fit = work.fit;
  const auto n = static_cast<Eigen::Index>(fit.chain.size());
  const int columns = work.options.sensitivity ? 4 : 1;
  Eigen::MatrixXd design(n, columns), means(n, 3), found;
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::size_t at = static_cast<std::size_t>(k);
    design(k, 0) = 1.0;
    if (columns == 4) design.block<1, 3>(k, 1) = work.options.gravity * fit.direction[at].transpose();
    means.row(k) = work.rests.all[fit.chain[at]].rate.transpose();
  }
  for (int pass = 0; pass < 5; ++pass) {
    found = (weight.asDiagonal() * design).colPivHouseholderQr().solve(weight.asDiagonal() * means);
    const Eigen::VectorXd size = (means - design * found).rowwise().norm();
    std::vector<double> sorted(size.data(), size.data() + n);
    std::nth_element(sorted.begin(), sorted.begin() + n / 2, sorted.end());
    const double middle = std::max(sorted[static_cast<std::size_t>(n / 2)], 1e-300);
    weight = (2.0 * middle / size.array().max(2.0 * middle)).sqrt();
    fit.scatter[1] = middle * middle / 3.0;
  }
  fit.calibration.gyro.bias = found.row(0).transpose();
  if (columns == 4) fit.calibration.sensitivity = found.bottomRows(3).transpose();
}

void add_groups(Fit& fit) {
  for (std::size_t k = 0; k < fit.chain.size(); ++k) {
    for (const Part part : {Part::force, Part::rate}) {
      if (part == Part::rate && fit.parameters == of_accelerometers) continue;
      Group group;
      group.part = part, group.index = fit.chain[k], group.pair = k;
      fit.groups.push_back(group);
    }
  }
  fit.from_first.resize(fit.chain.size());
  if (fit.parameters == of_accelerometers) return;
  fit.from_first[0] = Matrix3d::Identity();
  Group earth;
  earth.part = Part::earth;
  fit.groups.push_back(earth);
  for (std::size_t m = 0; m < fit.moves.size(); ++m) {
    if (!fit.moves[m].used()) continue;
    Group group;
    group.part = Part::turn, group.index = m;
    group.pair =
        static_cast<std::size_t>(std::find(fit.chain.begin(), fit.chain.end(), fit.moves[m].from) - fit.chain.begin());
    fit.groups.push_back(group);
  }
}

void start(const Work& work) {
  Fit& fit = work.fit;
  std::vector<Vector3d> means;
  for (std::size_t k = 0; k < work.rests.all.size(); ++k)
    if (work.rests.all[k].used()) fit.chain.push_back(k), means.push_back(work.rests.all[k].force);
  const auto sphere = fit_sphere(means, work.options.gravity);
  if (!sphere) throw_singular();
  check_force_unit(work.sessions[0], sphere->accelerometer.matrix);
  fit.calibration.accelerometer = sphere->accelerometer;
  const Matrix3d inverse = sphere->accelerometer.matrix.inverse();
  for (const auto& mean : means) fit.direction.push_back((inverse * (mean - sphere->accelerometer.bias)).normalized());
  fit.scatter[0] = sphere->scatter * sphere->scatter;
  if (!work.sessions[0].gyro.empty()) {
    start_rates(work);
    fit.moves = moves_between(work.sessions, work.rests, sphere->accelerometer);
    const auto gyro = start_of_gyro(work.sessions, work.rests, fit.moves, fit.calibration);
    if (gyro) {
      check_gyros(work.sessions[0], *gyro);
      fit.calibration.gyro.matrix = *gyro;
      fit.scatter[1] /= gyro->rowwise().squaredNorm().mean();
      fit.scatter[2] = 1e-4;
      fit.parameters = work.options.sensitivity ? with_sensitivity : with_gyros;
    } else {
      fit.no_gyros = "the moves do not turn about three axes, or too few of them are fit";
    }
  }
  fit.turns.resize(fit.moves.size());
  add_groups(fit);
}

/// Whether any was left out: single groups whose distance is far beyond the median of their part.
bool leave_out_far(const Work& work) {
  constexpr std::array<double, 3> beyond{8.0, 4.5, 5.5};  // about 5.5 sigma for 1, 3 and 2 degrees of freedom
  bool any = false;
  for (const Part part : parts) {
    std::vector<double> distances;
    std::size_t out = 0;
    for (Group& group : work.fit.groups) {
      if (group.part != part) continue;
      group.distance = distance_of(group, work.fit);
      out += group.used ? 0 : 1;
      if (group.used) distances.push_back(group.distance);
    }
    if (distances.size() < 8 || out > distances.size() / 4) continue;
    std::nth_element(distances.begin(), distances.begin() + static_cast<long>(distances.size() / 2), distances.end());
    const double middle = distances[distances.size() / 2];
    const double farthest = *std::max_element(distances.begin(), distances.end());
    for (Group& group : work.fit.groups) {
      if (group.part != part || !group.used || group.distance < 0.6 * farthest) continue;
      if (group.distance <= beyond[static_cast<std::size_t>(part)] * std::max(middle, 1e-3)) continue;
      group.used = false, any = true;
    }
  }
  return any;
}

void say_left_out(const Work& work) {
  for (const Group& group : work.fit.groups) {
    if (group.used) continue;
    std::string& why =
        group.part == Part::turn ? work.fit.moves[group.index].why_not : work.rests.all[group.index].why_not;
    if (!why.empty()) continue;
    why = group.part == Part::force  ? "|f| is far from gravity"
          : group.part == Part::rate ? "the gyros are far from their bias"
                                     : "the turn does not fit the rests at its ends";
  }
}

}  // namespace

Fit fit_all(const std::vector<Session>& sessions, Rests& rests, const FitOptions& options) {
  Fit fit;
  const Work work{sessions, rests, options, fit};
  start(work);
  fit.earth = earth_up(options) * fit.direction[0];
  linearise(work);
  iterate(work, 8, roughly);
  for (int pass = 0; pass < 10; ++pass) {
    find_scatter(1, fit);
    iterate(work, 3, roughly);
    if (!leave_out_far(work)) break;
    iterate(work, 3, roughly);
  }
  find_scatter(2, fit);
  iterate(work, 6, finely);
  say_left_out(work);
  add_uncertainty(rests.noise.degrees_of_freedom, fit);
  return fit;
}

}  // namespace tumble::imu_multi_position
