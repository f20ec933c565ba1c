#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::accelerometer_four_position {

/// Five temperatures in each of four power-ups, pulses counted over 5 s.
Trial trial(std::uint64_t seed);

/// A current of negative scale factor in four temperatures, from hot to cold, the instrument on its side; five
/// power-ups with the positions backwards in every second one, the last one without its last position.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::accelerometer_four_position
