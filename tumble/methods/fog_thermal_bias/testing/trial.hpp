#pragma once

#include <cstdint>

#include "tumble/methods/testing/trials.hpp"

namespace tumble::fog_thermal_bias {

/// A small thermal test: soaks at five temperatures and ramp runs from four start temperatures with both directions,
/// two rates, dwells and a reversal; second order in T, first in gradient and rate, linear in the start temperature.
Trial trial(std::uint64_t seed);

/// Another gyro: third order, all signs reversed, a start-up transient, more and other noise, coarser and slower
/// sensors whose gradient has the other sign, another reference, 14 runs in no order with lost samples.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::fog_thermal_bias
