#include "tumble/methods/imu_multi_position/moves.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tumble/core/say.hpp"

namespace tumble::imu_multi_position {
namespace {

Matrix3d skew(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
  return m;
}

/// Rotation by the vector v, active.
Matrix3d turned_by(const Vector3d& v) {
  const double square = v.squaredNorm(), angle = std::sqrt(square);
  double s = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0));         // sin(angle)/angle
  double c = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0));        // (1 - cos(angle))/angle^2
  if (square > 0.01) s = std::sin(angle) / angle, c = (1.0 - std::cos(angle)) / square;  // else exact to 1e-14
  Matrix3d m = c * v * v.transpose() + s * skew(v);
  m.diagonal().array() += 1.0 - c * square;
  return m;
}

/// What makes a move unfit, among gyro samples [first, last).
std::string fault_of(const Triad& gyro, std::size_t first, std::size_t last) {
  if (last >= gyro.time.size() || last <= first + 1) return "the gyros have no samples in it";
  for (const std::size_t after : gyro.gaps)
    if (after >= first && after < last)
      return "a gap at " + say_instant(gyro.time[after]) + ", " + say_seconds(gyro.time[after + 1] - gyro.time[after]);
  std::size_t missing = 0, clipped = 0;
  for (std::size_t i = first; i < last; ++i) {
    missing += gyro.value[i].allFinite() ? 0 : 1;
    clipped += gyro.clipped(i) ? 1 : 0;
  }
  if (missing > 0) return say_count(missing, "missing sample");
  if (clipped > 0) return "gyros at the end of their range in " + say_count(clipped, "sample");
  return "";
}

void add_forces(const Session& session, const Linear& accelerometer, std::size_t last, Move& move) {
  const Matrix3d inverse = accelerometer.matrix.inverse();
  const Triad& from = session.accelerometer;
  std::size_t at = from.index(session.gyro.time[move.first]);
  Vector3d force = Vector3d::Zero();
  move.force.reserve(last - move.first);
  for (std::size_t i = move.first; i < last; ++i) {
    while (at + 1 < from.time.size() && from.time[at + 1] <= session.gyro.time[i] + 0.5 * session.gyro.step) ++at;
    const Vector3d now = inverse * (from.value[std::min(at, from.value.size() - 1)] - accelerometer.bias);
    if (now.allFinite()) force = now;
    move.force.push_back(force);
  }
}

}  // namespace

std::vector<Move> moves_between(const std::vector<Session>& sessions, const Rests& rests, const Linear& accelerometer) {
  std::vector<Move> moves;
  std::size_t before = rests.all.size();
  for (std::size_t k = 0; k < rests.all.size(); ++k) {
    const Rest& rest = rests.all[k];
    if (!rest.used()) continue;
    const std::size_t from = before;
    before = k;
    if (from == rests.all.size() || rests.all[from].session != rest.session) continue;
    const Session& session = sessions[rest.session];
    if (session.gyro.empty()) continue;
    Move move;
    move.from = from, move.to = k;
    move.first = session.gyro.index(rests.all[from].end);
    const std::size_t last = session.gyro.index(rest.begin);
    move.why_not = fault_of(session.gyro, move.first, last);
    if (move.used()) {
      move.duration = session.gyro.time[last] - session.gyro.time[move.first];
      add_forces(session, accelerometer, last, move);
    }
    moves.push_back(std::move(move));
  }
  return moves;
}

Turn turn_of(const Triad& gyro, const Move& move, const Calibration& calibration, const Vector3d& earth) {
  const Matrix3d inverse = calibration.gyro.matrix.inverse();
  const std::size_t n = move.force.size();
  std::vector<Vector3d> angle(n + 2, Vector3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t s = move.first + i;
    angle[i + 1] = (gyro.time[s + 1] - gyro.time[s]) *
                   (inverse * (gyro.value[s] - calibration.gyro.bias - calibration.sensitivity * move.force[i]));
  }
  angle[0] = angle[1], angle[n + 1] = angle[n];
  Turn turn;
  turn.turned.fill(Matrix3d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    const double dt = gyro.time[move.first + i + 1] - gyro.time[move.first + i];
    const Vector3d seen = turn.rotation.transpose() * earth;  // and half a sample on: seen + seen x angle/2
    const Vector3d d = angle[i + 1] - dt * (seen + 0.5 * seen.cross(angle[i + 1]));
    const Matrix3d next = turn.rotation * turned_by(d + d.cross(angle[i + 2] - angle[i]) / 24.0);
    const Matrix3d middle = 0.5 * (turn.rotation + next);
    for (int j = 0; j < 3; ++j) {
      turn.turned[static_cast<std::size_t>(j)] += d[j] * middle;
      turn.turned[static_cast<std::size_t>(4 + j)] += (dt * move.force[i][j]) * middle;
    }
    turn.turned[3] += dt * middle;
    turn.path += d.norm();
    turn.about += d.cwiseAbs();
    turn.rotation = next;
  }
  return turn;
}

std::optional<Matrix3d> start_of_gyro(const std::vector<Session>& sessions, const Rests& rests,
                                      const std::vector<Move>& moves, const Calibration& calibration) {
  const Matrix3d inverse = calibration.accelerometer.matrix.inverse();
  const auto direction = [&](std::size_t rest) -> Vector3d {
    return (inverse * (rests.all[rest].force - calibration.accelerometer.bias)).normalized();
  };
  std::vector<Eigen::Matrix<double, 3, 9>> rows;
  std::vector<Vector3d> changes;
  for (const Move& move : moves) {
    if (!move.used()) continue;
    const Triad& gyro = sessions[rests.all[move.from].session].gyro;
    Eigen::Matrix<double, 3, 9> row = Eigen::Matrix<double, 3, 9>::Zero();
    for (std::size_t i = 0; i < move.force.size(); ++i) {
      const std::size_t s = move.first + i;
      const Vector3d v = gyro.value[s] - calibration.gyro.bias - calibration.sensitivity * move.force[i];
      const Matrix3d n = (gyro.time[s + 1] - gyro.time[s]) * skew(move.force[i].normalized());
      for (int j = 0; j < 3; ++j) row.middleCols<3>(3 * j) += v[j] * n;
    }
    rows.push_back(row);
    changes.push_back(direction(move.to) - direction(move.from));
  }
  if (rows.size() < 5) return {};
  std::vector<double> weight(rows.size(), 1.0);
  Eigen::Matrix<double, 9, 1> found;
  for (int pass = 0; pass < 3; ++pass) {
    Eigen::MatrixXd design(3 * rows.size(), 9);
    Eigen::VectorXd right(3 * rows.size());
    for (std::size_t m = 0; m < rows.size(); ++m) {
      design.middleRows<3>(3 * static_cast<int>(m)) = weight[m] * rows[m];
      right.segment<3>(3 * static_cast<int>(m)) = weight[m] * changes[m];
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
    qr.setThreshold(0.01);
    qr.compute(design);
    if (qr.rank() < 9) return {};
    found = qr.solve(right);
    for (std::size_t m = 0; m < rows.size(); ++m)
      weight[m] = 1.0 / std::max(0.2, (rows[m] * found - changes[m]).norm());  // sum of lengths, not of squares
  }
  const Matrix3d to_rate = Eigen::Map<const Matrix3d>(found.data());
  if (!(std::abs(to_rate.determinant()) > 0.0)) return {};
  return Matrix3d(to_rate.inverse());
}

}  // namespace tumble::imu_multi_position
