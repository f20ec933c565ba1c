#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::imu_turntable {

/// An IMU on a three-axis table: six faces in two headings, turning both ways with faces and edges up.
Plan trial_plan();
Trial trial(std::uint64_t seed);
/// The other way round: a southern site without measured gravity and with an uncertain latitude, parameters of the
/// other sign, offsets of a third of a g, the schedule backwards, one sample in fifty lost.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::imu_turntable
