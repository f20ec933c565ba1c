#pragma once

#include <cstdint>

#include "tumble/methods/method.hpp"

namespace tumble::imu_ferraris {

/// Six poses laid by hand and three turns on a table whose angle and axis the hand sets.
Trial trial(std::uint64_t seed);

}  // namespace tumble::imu_ferraris
