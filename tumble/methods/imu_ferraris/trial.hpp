#pragma once

#include <cstdint>

#include "tumble/methods/method.hpp"

namespace tumble::methods::ferraris {

/// Six poses laid by hand and three turns on a table whose angle and axis the hand sets.
Trial trial(std::uint64_t seed);

}  // namespace tumble::methods::ferraris
