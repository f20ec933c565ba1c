#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::accelerometer_four_position {

/// Five temperatures in each of four power-ups, pulses counted over 5 s.
Trial trial(std::uint64_t seed);

}  // namespace tumble::accelerometer_four_position
