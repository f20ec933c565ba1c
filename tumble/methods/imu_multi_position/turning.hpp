#pragma once

#include "tumble/core/finding.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"

namespace tumble::imu_multi_position {

/// An error finding where the accelerometers show that the unit turns in the rests, slowly and about the same axis of
/// the unit each time (it sinks into a soft base), and the biases of the gyros would hold this rate. By least squares
/// over the rests, n the direction up in the axes of the unit:
///
///   dn/dt = n x w
///
/// with the scatter of the rests about it. It is said where w is significant (chance 1e-5) and above twice the standard
/// uncertainty of a bias. A turn about n itself does not show in one rest; rests with other axes up show it.
Findings turning_rests(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit);

}  // namespace tumble::imu_multi_position
