#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::accelerometer_centrifuge {

/// Six levels to 20 g on a centrifuge in both senses of the input axis, and twelve positions in each mount of a
/// dividing head, read as pulses. The effective centre lies 1.3 mm further out than the plan says.
Trial trial(std::uint64_t seed);

/// As Method::second_trial.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::accelerometer_centrifuge
