#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::accelerometer_tumble {

/// 24 positions in a mixed order on a dividing head, 12 in each mount, half of them with the accelerometer turned by
/// 180 deg about its input axis, read as pulses.
Trial trial(std::uint64_t seed);

/// Irregular positions in both mounts and back, a voltage of negative scale factor, coefficients of the other sign, at
/// another site; samples are missing.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::accelerometer_tumble
