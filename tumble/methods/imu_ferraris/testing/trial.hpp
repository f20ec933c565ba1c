#pragma once

#include <cstdint>

#include "tumble/methods/testing/trials.hpp"

namespace tumble::imu_ferraris {

/// Six poses laid by hand and three turns on a table whose angle and axis the hand sets.
Trial trial(std::uint64_t seed);

/// The other way round in all that the first holds at zero or ideal: a southern site without measured gravity,
/// parameters of the other sign, offsets of half a g, poses that lean by more, bias instabilities that are stated, two
/// left-handed turns in each section of turns, a pose in two parts, and samples that are lost.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::imu_ferraris
