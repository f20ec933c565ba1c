#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::sine_vibration {

/// A counting accelerometer on a shaker, axis up and axis down, five frequencies at 3 g with rests between them.
Trial trial(std::uint64_t seed, const std::vector<Option>& options);

/// A trial with the effects that the first one has at zero or ideal. Given: options of the method.
Trial second_trial(std::uint64_t seed, const std::vector<Option>& options);

}  // namespace tumble::sine_vibration
