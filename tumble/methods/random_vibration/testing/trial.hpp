#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::random_vibration {

/// Units on a shaker, counted, at rest before and after 60 s of random vibration.
Trial trial(std::uint64_t seed, const std::vector<Option>& options);

/// A trial with the effects that the first one has at zero or ideal. Given: options of the method.
Trial second_trial(std::uint64_t seed, const std::vector<Option>& options);

}  // namespace tumble::random_vibration
