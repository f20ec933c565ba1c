#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::imu_channel_calibration {

/// An IMU on a two-axis table, its accelerometers on a dividing head and its gyros on a rate table before; all counted.
Trial trial(std::uint64_t seed);

}  // namespace tumble::imu_channel_calibration
