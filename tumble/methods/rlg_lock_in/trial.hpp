#pragma once

#include <cstdint>

#include "tumble/methods/method.hpp"

namespace tumble::rlg_lock_in {

/// A ring laser gyro on a rate table: 24 rates of both senses without dither, some of them in the dead band, and 20 s
/// at rest with a noisy dither.
Trial trial(std::uint64_t seed);

}  // namespace tumble::rlg_lock_in
