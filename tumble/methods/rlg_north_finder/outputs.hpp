#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/joint.hpp"
#include "tumble/reduce/table/recorded_angles.hpp"

/// A north finder on a two-axis table: one ring laser gyro along x and accelerometers along x and y, all of which
/// count.
///
///   N_G  = K   INT (w_x + gamma_y w_y + gamma_z w_z + eps) dt
///   N_Ax = K_x INT (f_x + a_xy f_y + a_xz f_z + b_x) dt
///   N_Ay = K_y INT (f_y + a_yx f_x + a_yz f_z + b_y) dt
namespace tumble::rlg_north_finder {

enum Which : std::size_t { gyro, accelerometer_x, accelerometer_y, outputs };

/// The regressor that the coefficient of a parameter multiplies.
struct Wanted;
Regressor regressor_of(const Wanted& parameter);

/// One parameter as the result has it, and the coefficient it comes from: the scale factor itself, the others times it.
struct Wanted {
  Which output;
  const char* name;
  const char* symbol;
  const char* unit;
  const char* coefficient_unit;
  const char* description;
  std::optional<Input> input;  ///< that the coefficient multiplies; absent: 1
};

constexpr std::size_t per_output = 4;  ///< scale factor, bias, two misalignments
const std::array<Wanted, outputs * per_output>& wanted();
const char* role_of(Which output);

std::vector<Role> roles();
std::vector<Option> options();

/// Pulses a second for one SI unit of a channel: its sampling rate [Hz] where it counts, 1 where it is in pulse/s.
/// Throws Error::bad_data for any other unit.
double per_second(const Channel& channel);

/// The outputs as linear problems in pulses a second.
std::array<linear::Problem, outputs> problems_of(const Plan& plan);

/// The evidence with outputs in pulses a second and the table angles that were recorded.
struct Prepared {
  Evidence evidence;
  table::RecordedAngles angles;  ///< without evidence
};

/// Throws Error::bad_data for outputs that do not count.
Prepared prepared(const Evidence& evidence);

}  // namespace tumble::rlg_north_finder
