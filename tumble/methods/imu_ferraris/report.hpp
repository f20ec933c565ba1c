#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_ferraris/uncertainty.hpp"

namespace tumble::imu_ferraris {

/// Names, symbols and units of parameters_of(), without values.
std::vector<Parameter> named_parameters(const Recorded& recorded);

/// K, R, b and K_ga as they are published, in the units of the channels.
Table matrices(const Calibration& calibration, const Recorded& recorded);

/// Each pose: how long, how noisy, and the size of the calibrated specific force, which should be gravity.
Table pose_table(const Means& means, const Calibration& calibration, const Recorded& recorded);

/// Greatest rates [rad/s] and specific forces [m/s^2] in any sample of the sections: what the session covers.
struct Extremes {
  Vector3 rate, force;
};
Extremes greatest(const Calibration& calibration, const Recorded& recorded);

/// The error models: each output by its scale factor, bias and direction, the gyros also by the specific force.
std::vector<OutputModel> models_of(const Estimate& estimate, const Calibration& calibration, const Recorded& recorded);

/// Greatest specific force along each axis and greatest rate about it in any sample of the sections: what the session
/// covers.
Table covered(const Calibration& calibration, const Recorded& recorded);

/// Exchanged, reversed or left-handed axes, labels and units; turns that are not whole; poses that were not still. With
/// `axes` = any exchanged or reversed axes are a warning, otherwise an error.
Findings faults(const Plan& plan, const Means& means, const Calibration& calibration, const Recorded& recorded);

}  // namespace tumble::imu_ferraris
