#pragma once

#include <cstdint>

#include "tumble/methods/testing/trials.hpp"

namespace tumble::rlg_north_finder {

/// The eight positions and three rotations of the path on a `two_axis_table` whose instrument sits with mount_yaw =
/// -90 deg, so that body y lies along the outer axis at angle 0 and body z along the inner one.
///
/// Given     stay   [s] at each position
///           turns  of each rotation, at 20 deg/s
Schedule path(double stay, int turns);

/// A ring laser gyro with accelerometers along x and y beside it, all counting, and the plan of their test.
/// Given: stay [s]; turns, whole revolutions.
Plan trial_plan(double stay, int turns);

/// True parameters of this plan, in the order of wanted() [SI].
std::vector<double> truth_of(const Plan& plan);

Trial trial(std::uint64_t seed);

/// The other way round: a southern site without measured gravity and with an uncertain latitude, parameters of the
/// other sign, a table that a hand sets to 0.3 deg and whose angles are recorded, samples of the stays lost.
Trial second_trial(std::uint64_t seed);

}  // namespace tumble::rlg_north_finder
