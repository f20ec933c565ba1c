#include "tumble/methods/imu_multi_position/moves.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/rotation.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr double least_part = 0.01;      ///< [1] of the largest column, below which the moves do not show another
constexpr std::size_t fewest_moves = 5;  ///< of three components each, for nine coefficients
constexpr int passes_of_start = 3;
constexpr double least_residual = 0.2;  ///< below it a residual has full weight: the start needs no more

/// Why a move with gyro samples [first, last) is not used; null: it is.
std::optional<Finding> rejection_of(const Triad& gyro, std::size_t first, std::size_t last) {
  using enum Finding::Severity;
  if (last >= gyro.time.size() || last <= first + 1) return Finding{warning, "move_without_samples", {}};
  for (const std::size_t after : gyro.gaps)
    if (after >= first && after < last)
      return Finding{warning,
                     "move_with_gap",
                     {{"begin", gyro.time[after], "s"}, {"length", gyro.time[after + 1] - gyro.time[after], "s"}}};
  std::size_t missing = 0, clipped = 0;
  for (std::size_t i = first; i < last; ++i) {
    missing += is_finite(gyro.value[i]) ? 0 : 1;
    clipped += gyro.clipped(i) ? 1 : 0;
  }
  if (missing > 0) return Finding{warning, "move_with_missing_samples", {{"missing", missing}}};
  if (clipped > 0) return Finding{warning, "move_clipped", {{"clipped", clipped}}};
  return {};
}

void add_forces(const Session& session, const Linear& accelerometer, std::size_t last, Move& move) {
  const Inverse felt(accelerometer);
  const Triad& from = session.accelerometer;
  std::size_t sample = from.index(session.gyro.time[move.first]);
  Vector3 force;
  move.force.reserve(last - move.first);
  for (std::size_t i = move.first; i < last; ++i) {
    const double middle = session.gyro.time[i] + 0.5 * session.gyro.step;
    while (sample + 1 < from.time.size() && from.time[sample + 1] <= middle) ++sample;
    const Vector3 now = felt(from.value[std::min(sample, from.value.size() - 1)]);
    if (is_finite(now)) force = now;
    move.force.push_back(force);
  }
}

/// Rotation of vectors by v [rad].
Matrix3 rotation_by(Vector3 v) { return matrix3(inverse(turned_by(v))); }

/// A move for the linear fit: change of the direction n [1] = sum_j of[j] (column j of W^-1).
struct Observed {
  std::array<Matrix3, 3> of;
  Vector3 change;

  Vector3 residual(const Matrix3& to_rate) const {
    Vector3 residual = change;
    for (std::size_t j = 0; j < 3; ++j) residual -= of[j] * column(to_rate, j);
    return residual;
  }
};

/// Integrals of y_j [n x] over a move, y the output of gyro j without bias and sensitivity.
std::array<Matrix3, 3> sensitivity_of(const Triad& gyro, const Move& move, const Calibration& calibration) {
  std::array<Matrix3, 3> of{};
  for (std::size_t i = 0; i < move.force.size(); ++i) {
    const std::size_t s = move.first + i;
    const Vector3 v = gyro.value[s] - calibration.gyro.bias - calibration.sensitivity * move.force[i];
    const Matrix3 n = (gyro.time[s + 1] - gyro.time[s]) * skew(normalised(move.force[i]));
    for (std::size_t j = 0; j < 3; ++j) of[j] += v[j] * n;
  }
  return of;
}

/// W^-1 by weighted least squares; null where the moves do not show it to 1 % of what they show best.
std::optional<Matrix3> fit_of(const std::vector<Observed>& observed, const std::vector<double>& weights) {
  Matrix design(3 * observed.size(), 9);
  std::vector<double> right;
  for (std::size_t m = 0; m < observed.size(); ++m)
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 9; ++j) design(right.size(), j) = weights[m] * observed[m].of[j / 3](i, j % 3);
      right.push_back(weights[m] * observed[m].change[i]);
    }
  const QrFit fit = qr_fit(design, right, least_part);
  if (fit.rank < 9) return {};
  Matrix3 to_rate;
  for (std::size_t j = 0; j < 3; ++j) set_column(to_rate, j, {fit.x[3 * j], fit.x[3 * j + 1], fit.x[3 * j + 2]});
  return to_rate;
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
    move.rejection = rejection_of(session.gyro, move.first, last);
    if (move.used()) {
      move.duration = session.gyro.time[last] - session.gyro.time[move.first];
      add_forces(session, accelerometer, last, move);
    }
    moves.push_back(std::move(move));
  }
  return moves;
}

Turn turn_of(const Triad& gyro, const Move& move, const Calibration& calibration, Vector3 earth) {
  const Inverse rate(calibration.gyro);
  const std::size_t n = move.force.size();
  std::vector<Vector3> angle(n + 2);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t s = move.first + i;
    angle[i + 1] = (gyro.time[s + 1] - gyro.time[s]) * rate(gyro.value[s] - calibration.sensitivity * move.force[i]);
  }
  angle[0] = angle[1], angle[n + 1] = angle[n];
  Turn turn;
  for (std::size_t i = 0; i < n; ++i) {
    const double dt = gyro.time[move.first + i + 1] - gyro.time[move.first + i];
    const Vector3 begin = transposed(turn.rotation) * earth;  // half a sample later: begin + begin x angle/2
    const Vector3 d = angle[i + 1] - dt * (begin + 0.5 * cross(begin, angle[i + 1]));
    const Matrix3 next = turn.rotation * rotation_by(d + cross(d, angle[i + 2] - angle[i]) / 24.0);
    const Matrix3 middle = 0.5 * (turn.rotation + next);
    for (std::size_t j = 0; j < 3; ++j) {
      turn.turned[j] += d[j] * middle;
      turn.turned[4 + j] += (dt * move.force[i][j]) * middle;
    }
    turn.turned[3] += dt * middle;
    turn.path += norm(d);
    turn.about += absolute(d);
    turn.rotation = next;
  }
  return turn;
}

std::optional<Matrix3> start_of_gyro(const std::vector<Session>& sessions, const Rests& rests,
                                     const std::vector<Move>& moves, const Calibration& calibration) {
  const Inverse felt(calibration.accelerometer);
  const auto direction = [&](std::size_t rest) { return normalised(felt(rests.all[rest].force)); };
  std::vector<Observed> observed;
  for (const Move& move : moves)
    if (move.used())
      observed.push_back({sensitivity_of(sessions[rests.all[move.from].session].gyro, move, calibration),
                          direction(move.to) - direction(move.from)});
  if (observed.size() < fewest_moves) return {};
  Matrix3 to_rate;
  std::vector<double> weights(observed.size(), 1.0);
  for (int pass = 0; pass < passes_of_start; ++pass) {
    const auto fit = fit_of(observed, weights);
    if (!fit) return {};
    to_rate = *fit;
    for (std::size_t m = 0; m < observed.size(); ++m)
      weights[m] =
          1.0 / std::max(least_residual, norm(observed[m].residual(to_rate)));  // sum of lengths, not of squares
  }
  if (!(std::abs(determinant(to_rate)) > 0.0)) return {};
  return inverse(to_rate);
}

}  // namespace tumble::imu_multi_position
