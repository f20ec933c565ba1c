#pragma once

#include <string>
#include <vector>

#include "tumble/models/model.hpp"

/// Three sensors of one kind at right angles, as tables of terms: what `triad` and `imu` are made of.
namespace tumble::axes {

/// Gyros with the input axes x, y, z: channels gyro_x, gyro_y, gyro_z, terms gyro_x_bias and so on.
///
///   w_i + bias + scale_factor_error w_i + sum_j misalignment_j w_j + sum_j acceleration_sensitivity_j f_j
std::vector<Output> gyros();

/// Accelerometers, each at a point of its own: channels accelerometer_x, ..., terms accelerometer_x_bias and so on.
///
///   f_i + bias + scale_factor_error f_i + sum_j misalignment_j f_j + second_order f_i^2
///       + [a x r + w x (w x r)]_i,   r = (lever_x, lever_y, lever_z) of axis i, a the angular acceleration
std::vector<Output> accelerometers();

/// Range, resolution and kind of output (means, increments or counts of pulses), for each of the kinds of sensor.
std::vector<Option> options(bool gyros, bool accelerometers);

/// Clipping, resolution, increments or pulses. Throws Error::bad_input for pulses without a scale factor.
/// Given: step of the simulation [s].
Recorded record(const Output& output, const Settings& truth, double step, const RandomStream& random);

}  // namespace tumble::axes
