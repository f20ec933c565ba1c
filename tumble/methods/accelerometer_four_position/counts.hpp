#pragma once

#include <string>

#include "tumble/core/evidence.hpp"
#include "tumble/methods/accelerometer_four_position/positions.hpp"

/// Pulses per counting window, and their faults.
namespace tumble::accelerometer_four_position {

/// The evidence with the channel of that role alone, counts as pulses per second: each divided by its own window. Where
/// stamps differ and the counts follow them, a window lasts to the next stamp; the count before a gap shows whether it
/// holds the pulses of several windows or of one.
Evidence per_second(const Evidence& evidence, const std::string& role, Findings& findings);

/// Throws Error::bad_data where a position is off by a power of two of pulses, as by a counter that overflowed.
void refuse_overflow(const Bench& bench);

}  // namespace tumble::accelerometer_four_position
