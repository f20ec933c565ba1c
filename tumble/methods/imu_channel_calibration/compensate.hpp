#pragma once

#include "tumble/methods/imu_channel_calibration/compare.hpp"
#include "tumble/reduce/compensate.hpp"

namespace tumble::imu_channel_calibration {

/// Table `regressors` of the calibrations of the whole unit, for `compensate`.
Table covered(const std::vector<Pair>& pairs);

/// (3.4) of the whole unit applied to the channels of a recording.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan,
                        const std::vector<Option>& options);

}  // namespace tumble::imu_channel_calibration
