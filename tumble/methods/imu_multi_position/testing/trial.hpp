#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::imu_multi_position {

/// A micromechanical unit laid down by hand 24 ways. Its accelerometers round to steps, which is the scatter from rest
/// to rest; the hand shakes; gravity is known to a part.
Trial trial(std::uint64_t seed, const std::vector<Option>& options);

/// The other way round in what the first holds at ideal: a southern site without measured gravity, parameters of the
/// other sign, larger offsets, the poses in another order and for another time, one sample in thirty lost.
Trial second_trial(std::uint64_t seed, const std::vector<Option>& options);

}  // namespace tumble::imu_multi_position
