#pragma once

#include <span>

#include "tumble/core/channel.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::accelerometer_four_position {

/// Mean over a stretch, and second half less first.
struct Halves {
  double mean = 0.0, change = 0.0;  ///< [u]; NaN and 0 where there are no samples
};

/// Given: one value [u] a sample of the channel, NaN: missing. Returned: [u].
Halves halves_of(const Channel& channel, std::span<const double> values, const Stretch& stretch);

}  // namespace tumble::accelerometer_four_position
