#pragma once

#include <cstdint>

#include "tumble/methods/testing/trials.hpp"

namespace tumble::rlg_lock_in {

/// A ring laser gyro on a rate table: 24 rates of both senses without dither, some of them in the dead band, and 20 s
/// at rest with a noisy dither.
Trial trial(std::uint64_t seed);

/// Another gyro on another site: most of the 28 rates are near the edges of the dead band, where white noise acts more;
/// a negative bias, a square ring, two edges a fringe, another dither.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::rlg_lock_in
