#pragma once

#include "tumble/methods/rlg_north_finder/outputs.hpp"
#include "tumble/reduce/compensate.hpp"

namespace tumble::rlg_north_finder {

/// Table `regressors`: the range of each term in the test.
Table covered(const linear::JointSolution& solution);

/// Counts become the angular rate about x and the specific forces along x and y. The gyro's misalignments need rate_y
/// and rate_z, those of the accelerometers specific_force_z: from channels of these names or the plan. Throws as
/// tumble::compensate.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::rlg_north_finder
