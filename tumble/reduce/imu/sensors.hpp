#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "tumble/core/channel.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/math/vector3.hpp"
#include "tumble/models/model.hpp"

/// Sensors, roles and readings of an inertial measurement unit.
namespace tumble::imu {

enum class Kind { accelerometer, gyro };

inline constexpr std::array<Kind, 2> kinds{Kind::accelerometer, Kind::gyro};
inline constexpr std::array<char, 3> letters{'x', 'y', 'z'};

/// Prefix of the settings for one kind.
constexpr const char* prefix_of(Kind kind) { return kind == Kind::gyro ? "gyro_" : "accelerometer_"; }

/// "accelerometer_x"
std::string role_of(Kind kind, std::size_t axis);

/// Component 0, 1 or 2 of a vector [u].
constexpr double component(Vector3 v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
/// Field that sensors of this kind measure: angular rate [rad/s] or specific force [m/s^2].
constexpr Vector3 field_of(Kind kind, const Felt& felt) { return kind == Kind::gyro ? felt.rate : felt.specific_force; }

/// Sampling rate [Hz] of a channel, without the pauses of the recording.
double samples_per_second(const Channel& channel);

/// Scale and pulse of a channel [SI of the quantity] for one SI unit of it.
struct Reading {
  double scale = 1.0;
  double pulse = 0.0;  ///< 0: no pulses are counted
};

/// Reading of angular rate or specific force, angle or velocity increments, or pulses (of accelerometers also mA, V).
/// Pulses, mA and V need the setting `gyro_scale_factor` or `accelerometer_scale_factor`.
/// Throws Error::bad_input without that setting, bad_data for another quantity.
Reading reading_of(Kind kind, const Settings& settings, const Channel& channel);

/// Options `accelerometer_scale_factor` and `gyro_scale_factor`.
std::vector<Option> scale_factor_options();

}  // namespace tumble::imu
