#pragma once

#include <array>
#include <vector>

#include "tumble/methods/imu_ferraris/uncertainty.hpp"

namespace tumble::imu_ferraris {

/// By how much the gyros' bias at the ends of each turn, where the unit is at rest there, differs from that of the poses
/// [unit of the outputs]: zero where it does not by more than noise and drift.
std::array<Vector3, turns> bias_changes(const Means& means, const Calibration& calibration, const Recorded& recorded);

/// Adds causes that a sound turn does not have: missing samples, and a bias that changed since the poses.
void add_turn_causes(const Means& means, const Calibration& calibration, const Recorded& recorded,
                     std::vector<Cause>& all);

}  // namespace tumble::imu_ferraris
