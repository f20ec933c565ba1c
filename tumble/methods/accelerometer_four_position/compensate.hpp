#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::accelerometer_four_position {

/// Specific force from the output of the accelerometer, docs/equations (3.4) for one channel:
///
///   A = (1 + dK(T)) N/(K_m H) - nabla(T)
///
/// The channel keeps its name and becomes a specific force. Beside it `<name>.compensation_sd` (uncertainty of the
/// compensation at the given output) and `<name>.extrapolated` (1 outside of the calibrated temperatures).
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::accelerometer_four_position
