#pragma once

#include <cstdint>

#include "tumble/methods/testing/trials.hpp"

namespace tumble::static_bias {

/// Eight power-ups of a gyro with bias instability and rate random walk, 20 min each.
Trial trial(std::uint64_t seed);

/// Ten power-ups of an accelerometer that points down and counts coarsely: a negative bias, a repeatability of three
/// times the noise within a run, 400 s each with a gap and lost samples.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::static_bias
