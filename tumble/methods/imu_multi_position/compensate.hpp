#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"
#include "tumble/reduce/compensate.hpp"

namespace tumble::imu_multi_position {

/// Table `regressors`: what the accelerometers felt in the rests, the gyros in rests and moves, for `compensate`.
Table covered(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit, const Estimate& estimate);

/// f = A^-1 (y_a - a), rate = W^-1 (y_g - G f - b), of the triads that the recording has. Throws Error::bad_data for
/// channels in another kind of unit than was calibrated, and as tumble::compensate.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::imu_multi_position
