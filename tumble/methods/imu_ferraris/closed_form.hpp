#pragma once

#include <array>
#include <vector>

#include "tumble/math/matrix3.hpp"

/// Six poses and three turns, reduced in closed form. Outputs are raw: SI of whatever unit the channels are in.
namespace tumble::imu_ferraris {

inline constexpr std::size_t poses = 6;  ///< x up, x down, y up, y down, z up, z down
inline constexpr std::size_t turns = 3;  ///< about x, y, z

/// The axis that a pose lays along the vertical, and whether it points up (+1) or down (-1) [1].
constexpr std::size_t axis_of(std::size_t pose) { return pose / 2; }
constexpr double sign_of(std::size_t pose) { return pose % 2 == 0 ? 1.0 : -1.0; }

/// Means over the sections, and what was done to the unit.
struct Means {
  std::array<Vector3, poses> force, rate;  ///< mean output of the accelerometers and gyros
  std::array<double, poses> samples{};     ///< weights of the poses in the bias of the gyros
  std::array<Vector3, turns> turned;       ///< output of the gyros integrated over the turn [output s]
  std::array<Vector3, turns> turn_force;   ///< mean output of the accelerometers in it
  std::array<double, turns> turn_time{};   ///< [s]
  std::array<double, turns> angle{};       ///< [rad]
  double gravity = 0.0;                    ///< [m/s^2]
  bool gyros = false;
};

/// a = K_a R_a f + b_a,  w = K_g R_g rate + K_ga f + b_g: scale factors, direction cosines of the input axes, biases.
struct Calibration {
  Vector3 k_a, b_a, k_g, b_g;
  Matrix3 r_a, r_g, k_ga;
  bool gyros = false;
};

/// With U_p and U_n the 3 x 3 means of the poses with x, y, z up and down, column by column, and W the integrals:
///
///   b_a = diag(U_p + U_n)/2,   K_a R_a = (U_p - U_n)/(2 g),   K_ga = (V_p - V_n)/(2 g),   b_g = mean of V,
///   K_g R_g = (integral of w - K_ga (K_a R_a)^-1 (a - b_a) - b_g) / angle,
///
/// where the rows of R have unit length.
///
/// Throws    Error::bad_data where the accelerometers do not span the three directions
/// See       F. Ferraris, U. Grimaldi, M. Parvis, Procedure for effortless in-field calibration of three-axis rate
/// gyros
///           and accelerometers, Sensors and Materials 7, 1995
Calibration closed_form(const Means& means);

/// K R: output [SI] for a unit of input along each axis, by scale factors k [SI] and direction cosines r [1].
Matrix3 response(Vector3 k, const Matrix3& r);

/// Parameters [SI], for each accelerometer: scale factor, bias, misalignment toward the two other axes; then of each
/// gyro the same and its sensitivity to specific force along x, y, z [SI].
std::vector<double> parameters_of(const Calibration& calibration);

}  // namespace tumble::imu_ferraris
