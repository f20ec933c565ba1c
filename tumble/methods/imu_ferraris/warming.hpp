#pragma once

#include <vector>

#include "tumble/methods/imu_ferraris/uncertainty.hpp"

namespace tumble::imu_ferraris {

/// Adds the biases of the accelerometers that settle while the unit becomes warm to the causes, and says so where it is beyond
/// doubt. By least squares over the differences d_p of the halves of all poses, for each accelerometer
///
///   d_p = A h_p,   h_p the difference of exp(-t/T) between the halves, t since the first pose of the recording
///
/// with the T, of four from a twentieth to 0.4 of the session, that shows A best. In the budget where a sound test shows as
/// much once in 100.
void add_warming(const Recorded& recorded, Findings& findings, std::vector<Cause>& all);

}  // namespace tumble::imu_ferraris
