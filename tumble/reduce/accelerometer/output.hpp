#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/role.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/linear/linear.hpp"

/// Reading of an output as specific force, which the methods for accelerometers share.
namespace tumble::accelerometer {

/// The output of an accelerometer, in any of its units.
std::vector<Role> roles();

/// Form in which an accelerometer shows specific force: E = K_1 A, A the indicated specific force.
struct Output {
  Unit scale_factor;        ///< of K_1 as shown: pulse/s/g, mA/g, V/g; "1" where the output is a specific force
  double per_second = 1.0;  ///< E [SI] for one SI unit of the channel: pulses are counted per window of 1/per_second
  bool pulses = false;
};

/// From the channel's unit. Throws Error::bad_data where it is no output of an accelerometer.
Output output_of(const Channel& channel);

/// The output that a pendulous_accelerometer with this [truth] records. Given: sample_rate [Hz].
Output output_of(const Settings& truth, double sample_rate);
/// K_1 of that accelerometer [SI].
double scale_factor_of(const Settings& truth);
/// Terms of the model of these names, with the default constants.
std::vector<Term> terms_of(const std::vector<std::string>& names);

/// Option `scale_factor`, a text: its unit depends on the output.
Option scale_factor_option(const std::string& description);
/// Value [SI] of that option; nothing where it is absent. Throws Error::bad_input.
std::optional<double> given_scale_factor(const Settings& settings, const Output& output);

/// The error model with the terms of these names that the fit has; K_1 is that of the result where it has one, else
/// that of the settings.
void set_model(const Evidence& evidence, const linear::Solution& solution, const std::vector<std::string>& names,
               Estimate& estimate);

/// The scale factor [SI] of the settings, which must give it unless the output is a specific force: 1.
/// Throws Error::bad_input, bad_data.
double required_scale_factor(const Settings& settings, const Channel& channel);

/// Specific force [SI] for one SI unit of the channel, with the scale factor of the settings. Throws as
/// required_scale_factor.
double scale_of(const Settings& settings, const Channel& channel);

}  // namespace tumble::accelerometer
