#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_ferraris/uncertainty.hpp"

namespace tumble::imu_ferraris {

/// Names, symbols and units of parameters_of(), without values.
std::vector<Parameter> named_parameters(const Recorded& recorded);

/// K, R, b and K_ga as they are published, in the units of the channels. The signs of the diagonals of R, which are no
/// parameters, are read by compensate.
Table matrices(const Calibration& calibration, const Recorded& recorded);

/// Each pose: how long, how noisy, and the size of the calibrated specific force, which should be gravity.
Table pose_table(const Means& means, const Calibration& calibration, const Recorded& recorded);

/// Greatest specific force along each axis and greatest rate about it in any sample of the sections: what the session
/// covers.
Table covered(const Calibration& calibration, const Recorded& recorded);

/// Exchanged, reversed or left-handed axes, labels and units; turns that are not whole; poses that were not still. With
/// `axes` = any exchanged or reversed axes are a warning, otherwise an error.
Findings faults(const Plan& plan, const Means& means, const Calibration& calibration, const Recorded& recorded);

}  // namespace tumble::imu_ferraris
