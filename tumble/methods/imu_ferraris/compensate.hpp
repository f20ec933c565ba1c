#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::imu_ferraris {

/// f = R_a^-1 K_a^-1 (a - b_a), rate = R_g^-1 K_g^-1 (w - K_ga f - b_g), by the parameters of the result, under the
/// names of the channels. Each has a channel `NAME.compensation_sd`, its standard uncertainty from that of the
/// calibration, and `NAME.extrapolated`, 1 beyond the specific forces and rates of the session.
/// Throws Error::bad_data for missing channels and other units, bad_file for a result without its parameters.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::imu_ferraris
