#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::vibration {

/// How the values of a channel become specific force.
enum class Reading { force, velocity, electric, pulses };

/// Throws Error::bad_data for a unit that no accelerometer gives. A velocity increment is read as well.
Reading reading_of(const Channel& channel);

/// K_1 of the unit as the settings give it [SI of the channel, per second where it counts, per m/s^2]; none: not given.
/// Throws Error::bad_input for a text that cannot be read, or a dimension that is not the channel's.
std::optional<double> given_scale(const Settings& settings, const UnitUnderTest& unit, const Channel& channel);

/// Names of units in a scale_factor that says each its own; empty where one is for all.
std::vector<std::string> named_in_scale(const Settings& settings);

/// Units whose scale factor the setting gives more than once; empty for that of all.
std::vector<std::string> twice_in_scale(const Settings& settings);

/// K_1 by least squares through zero over the segments at rest, whose `force` still holds values of the channel, per
/// second where it counts. `relative_sd`: of a bias of `bias_sd` common to all of them. None: no such segment with
/// 0.2 g along the input axis.
struct RestScale {
  double scale = 0.0;
  double relative_sd = 0.0;  ///< [1]
};
/// Given: bias_sd [m/s^2].
std::optional<RestScale> scale_at_rest(const std::vector<const Series*>& at_rest, double bias_sd);

}  // namespace tumble::vibration
