#pragma once

#include "tumble/methods/testing/trials.hpp"

namespace tumble::imu_channel_calibration {

/// An IMU on a two-axis table, its accelerometers on a dividing head and its gyros on a rate table before; all counted.
Trial trial(std::uint64_t seed);

/// The other way round: a southern site without measured gravity and with an uncertain latitude, which all parts share,
/// parameters of the other sign, one sample in two hundred lost.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::imu_channel_calibration
