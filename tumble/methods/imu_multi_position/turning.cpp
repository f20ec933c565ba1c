#include "tumble/methods/imu_multi_position/turning.hpp"

#include <cmath>

#include "tumble/methods/imu_multi_position/rests.hpp"
#include "tumble/methods/imu_multi_position/start.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr std::size_t fewest_turning = 9;  ///< rests: 15 degrees of freedom remain after bias and sensitivities

/// Rate [rad/s] that the rests share, and how far from zero it is.
struct SharedTurn {
  Vector3 rate;
  double ratio = 0.0;  ///< [1] F of three and `degrees` degrees of freedom
  double degrees = 0.0;
};

/// Rests weigh as the noise of the change of their halves lets them: by the cube of their length.
SharedTurn shared_turn(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit) {
  const Matrix3 felt = inverse(fit.calibration.accelerometer.matrix);
  Matrix3 normal;
  Vector3 right;
  double squares = 0.0;
  for (std::size_t k = 0; k < fit.chain.size(); ++k) {
    const Rest& rest = rests.all[fit.chain[k]];
    const Vector3 n = fit.direction[k], change = felt * drift_of(sessions[rest.session].accelerometer, rest);
    const double length = rest.end - rest.begin, weight = length * length * length;
    const Vector3 slope = (change - dot(change, n) * n) / (0.5 * length * norm(felt * rest.force));
    normal = normal + weight * (identity3() - outer(n, n));
    right += weight * cross(slope, n);
    squares += weight * dot(slope, slope);
  }
  SharedTurn turn{inverse(normal) * right, 0.0, 2.0 * static_cast<double>(fit.chain.size()) - 3.0};
  const double explained = dot(turn.rate, right);
  turn.ratio = explained / 3.0 / ((squares - explained) / turn.degrees);
  return turn;
}

}  // namespace

Findings turning_rests(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit) {
  constexpr double certain = 14.0;  // chance 1e-5 or less of F with 3 and 15 or more degrees of freedom
  if (fit.parameters == of_accelerometers || fit.chain.size() < fewest_turning) return {};
  const SharedTurn turn = shared_turn(sessions, rests, fit);
  if (!(turn.ratio > certain)) return {};
  const Vector3 shift = fit.calibration.gyro.matrix * turn.rate;
  bool matters = false;
  for (std::size_t row = 0; row < 3; ++row)
    matters = matters || std::abs(shift[row]) > 2.0 * std::sqrt(fit.covariance(gyro_index(row, 3), gyro_index(row, 3)));
  if (!matters) return {};
  return {{Finding::Severity::error,
           "unit_turns_at_rest",
           {{"rate", norm(turn.rate), "deg/h"},
            {"x", turn.rate.x, "deg/h"},
            {"y", turn.rate.y, "deg/h"},
            {"z", turn.rate.z, "deg/h"}},
           "gyros"}};
}

}  // namespace tumble::imu_multi_position
