#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tumble/methods/imu_multi_position/rests.hpp"
#include "tumble/methods/imu_multi_position/start.hpp"

namespace tumble::imu_multi_position {

/// The calibration sought: y_a = A f + a,  y_g = W w + G f + b  [unit of the channels].
struct Calibration {
  Linear accelerometer;  ///< A lower triangular: x of the body is the input axis of x
  Linear gyro;           ///< W, b
  Matrix3 sensitivity;   ///< G
};

/// From the end of one rest to the beginning of the next that is used.
struct Move {
  std::size_t from = 0, to = 0;      ///< indices of rests
  double duration = 0.0;             ///< [s]
  std::optional<Finding> rejection;  ///< why it is not used
  std::vector<Vector3> force;        ///< specific force at each gyro sample [m/s^2], as the accelerometers show it
  std::size_t first = 0;             ///< gyro sample
  bool used() const { return !rejection; }
};

/// The turn of a move and how it depends on what is felt, in the axes at its beginning:
///
///   d phi = -sum_j turned[j] W^-1 dc_j,   c_j the columns of [W | b | G]
struct Turn {
  Matrix3 rotation = identity3();   ///< axes at the beginning from axes at the end
  std::array<Matrix3, 7> turned{};  ///< integral of R(t) x_j dt, x = (w, 1, f) [rad, s, m/s]
  double path = 0.0;                ///< [rad] integral of |w|
  Vector3 about;                    ///< [rad] integrals of |w_x|, |w_y|, |w_z|
};

/// One for each pair of neighbours among the rests that are used, in each session. A move with gaps, missing or clipped
/// samples is rejected.
std::vector<Move> moves_between(const std::vector<Session>& sessions, const Rests& rests, const Linear& accelerometer);

/// Rotations sample by sample, each the increment and half of the cone that it and its neighbours span:
///
///   phi_i = d_i + d_i x (d_(i+1) - d_(i-1))/24,   d_i = W^-1 (y_i - b - G f_i) dt
///
/// See  P. G. Savage, Strapdown inertial navigation integration algorithm design, part 1, 1998 (coning)
///
/// `earth` [rad/s]: its rotation in the axes at the beginning, which is subtracted.
Turn turn_of(const Triad& gyro, const Move& move, const Calibration& calibration, Vector3 earth);

/// W without a starting value, linear: along each move dn/dt = n x w with the direction n that the accelerometers
/// show, W^-1 by least squares over the moves. Null where the moves do not show it.
std::optional<Matrix3> start_of_gyro(const std::vector<Session>& sessions, const Rests& rests,
                                     const std::vector<Move>& moves, const Calibration& calibration);

}  // namespace tumble::imu_multi_position
