#pragma once

#include "tumble/methods/imu_ferraris/sections.hpp"

namespace tumble::imu_ferraris {

/// A warning where one pose leans far more than the others: of the six sums of two opposite poses across the vertical, which
/// without tilts are the bias, one is far from it and the others are not.
Findings leaning_poses(const Means& means, const Calibration& calibration);

}  // namespace tumble::imu_ferraris
