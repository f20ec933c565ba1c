#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::fog_thermal_bias {

/// Subtracts the predicted drift from the gyro of a recording, docs/equations (5.4): L_c = L - sum a_i(T_0) phi_i. The
/// level L_0 stays. Beside the compensated channel the recording gains `<gyro>.compensation_sd` (uncertainty of what
/// was subtracted, phi' Cov(a) phi) and `<gyro>.extrapolated` (1 outside of the calibrated range). Each power-up has
/// its own T_0.
Compensation compensate(const Estimate& estimate, const Recording& recording);

}  // namespace tumble::fog_thermal_bias
