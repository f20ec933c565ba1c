#pragma once

#include <cstdint>

#include "tumble/methods/method.hpp"

namespace tumble::fog_thermal_bias {

/// A small thermal test: soaks at five temperatures and ramp runs from four start temperatures with both directions,
/// two rates, dwells and a reversal; second order in T, first in gradient and rate, linear in the start temperature.
Trial trial(std::uint64_t seed);

}  // namespace tumble::fog_thermal_bias
