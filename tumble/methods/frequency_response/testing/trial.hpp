#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::frequency_response {

/// Stepped sines on a second-order loop with delay, read as means over 2 ms beneath coloured noise, against a reference
/// at another rate with its own noise, clock and gain error.
Trial trial(std::uint64_t seed, const std::vector<Option>& options);

/// A trial with the effects that the first one has at zero or ideal. Given: options of the method.
Trial second_trial(std::uint64_t seed, const std::vector<Option>& options);

}  // namespace tumble::frequency_response
