#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tumble/math/rotation.hpp"
#include "tumble/math/vector3.hpp"

/// North finding: a gyro with a level input axis at index angles about the vertical axis of a base.
///
///   y   = K (w_x + gamma_y w_y + gamma_z w_z + eps + d (t - t_0)),       w = R w_b + turn of the table
///   y_x = K_x (f_x + a_xy f_y + a_xz f_z + b_x),                         f = R f_b,   and the same about y
///   w_b = w_ie (cos(phi) n_b + sin(phi) u_b),   f_b = g u_b
///
/// n_b north and u_b up in the axes of the base; R the turn of the body in the base, about z by the index angle.
namespace tumble::north_finding {

enum Channel : std::size_t { gyro, accelerometer_x, accelerometer_y, channels };

/// All that the outputs depend on [SI].
enum Quantity : std::size_t {
  azimuth,
  pitch,
  roll,
  latitude,
  gravity_here,
  gyro_scale,
  gyro_bias,
  gyro_drift,
  gyro_y,
  gyro_z,
  x_scale,
  x_bias,
  x_y,
  x_z,
  y_scale,
  y_bias,
  y_x,
  y_z,
  quantities
};
using State = std::array<double, quantities>;

inline bool contains(const std::vector<Quantity>& some, Quantity quantity) {
  return std::ranges::find(some, quantity) != some.end();
}

constexpr Quantity scale_of(Channel channel) {
  return channel == gyro ? gyro_scale : channel == accelerometer_x ? x_scale : y_scale;
}
constexpr Quantity bias_of(Channel channel) {
  return channel == gyro ? gyro_bias : channel == accelerometer_x ? x_bias : y_bias;
}
const char* role_of(Channel channel);

/// North and up in the axes of the base.
struct Directions {
  Vector3 north, up;
};

/// The base whose x has this azimuth A (of its horizontal projection, from north to the east) and elevation p (pitch),
/// turned about x by r (roll, right-handed: y up). At p = r = 0 x is level at A, y level and to its left, z up.
///
///   u_b = [sin p, cos p sin r, cos p cos r]
Directions directions_of(double azimuth, double pitch, double roll);

/// Attitude and turn of the body in the base, at one instant or over a short time.
struct View {
  double weight = 1.0;
  Rotation turn;  ///< R, body from base
  Vector3 spin;   ///< of the table against the ground, in body axes [rad/s]
  Vector3 force;  ///< beside gravity: of a lever arm, in body axes [m/s^2]
};

/// A mean of one channel.
struct Row {
  Channel channel = gyro;
  std::size_t position = 0;      ///< in which stretch or revolution of its channel
  double seconds = 0.0;          ///< of samples
  double time = 0.0;             ///< [s] from t_0
  double output = 0.0;           ///< [SI of the channel, counts per second]; NaN where predicted
  std::vector<View> views = {};  ///< whose weights add up to 1
  double rounding_sd = 0.0;      ///< to whole pulses, of the mean of a stay
  double reading_sd = 0.0;       ///< of a turn: rounding of the readings at its two ends
  bool follows = false;          ///< begins with the reading with which the row before ends
  std::size_t power_up = 0;      ///< in the evidence
  int run = 1;
  std::size_t start = 0;  ///< see MarkedSegment
  double at = 0.0;        ///< [s] the middle, in the power-up
};

/// Sensitivity of the row to a unit field along x and y of the base [1].
std::pair<double, double> sensitivity_in_base(const Row& row);
/// Output of the channel by the model [SI of the channel, counts per second].
double output_of(const State& state, const Row& row);
/// Output of the channel by the model [SI of the channel, counts per second] with other views.
double output_of(const State& state, const Row& row, const std::vector<View>& views);
/// Derivatives of the output [quantities].
std::array<double, quantities> slopes_of(const State& state, const Row& row);

/// (2.12): azimuth from the horizontal parts of the Earth's rate [rad/s] and of up (a unit vector) in the base.
///
///   w_bz = (w_ie sin(phi) - u_x w_bx - u_y w_by)/u_z,   n = w_b - (w_b.u) u,   e = n x u,   A = atan2(e_x, n_x)
double exact_azimuth(double rate_x, double rate_y, double up_x, double up_y, double latitude);

}  // namespace tumble::north_finding
