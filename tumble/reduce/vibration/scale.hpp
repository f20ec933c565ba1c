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

/// Names of units in a scale_factor that gives each unit its own; empty where one is for all.
std::vector<std::string> named_in_scale(const Settings& settings);

/// Units whose scale factor the setting gives more than once; an empty name means the one for all units.
std::vector<std::string> twice_in_scale(const Settings& settings);

/// Sets pulse and K_1 of a unit: as given, else by least squares over its segments at rest; with it, the values of all
/// its series become specific forces [m/s^2]. Throws Error::bad_input where neither gives K_1.
void set_scale(const Settings& settings, const Channel& channel, std::size_t unit, Data& data);

}  // namespace tumble::vibration
