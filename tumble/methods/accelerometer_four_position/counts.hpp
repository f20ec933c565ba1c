#pragma once

#include <string>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/accelerometer_four_position/positions.hpp"

/// Pulses per counting window, and what can be wrong with them.
namespace tumble::accelerometer_four_position {

/// K_m [SI] of the settings; 1 where the output is a specific force. Throws Error::bad_input where it is needed.
double reference_scale_factor(const Settings& settings, const accelerometer::Output& output);

/// The evidence with the channel of that role alone, counts as pulses per second: each divided by its own window. Where
/// stamps differ and the counts go with them, a window lasts to the next stamp; after a gap the count tells whether it
/// holds the pulses of several windows or only one.
Evidence per_second(const Evidence& evidence, const std::string& role, Findings& findings);

/// Throws Error::bad_data where a position is off by a power of two of pulses, as by a counter that ran over.
void refuse_overflow(const Bench& bench);

}  // namespace tumble::accelerometer_four_position
