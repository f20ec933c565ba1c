#pragma once

#include "tumble/rigs/chain/machine.hpp"

namespace tumble::chain {

/// Parts that the rigs with a centrifuge's arm share. The arm is axis 0 and turns about z (upwards); x points radially
/// outwards.

/// The drive of the arm.
MachineAxis arm_axis();
/// Radius, its stretch, azimuth of the arm at angle 0. `end` is what the radius goes to.
std::vector<Option> arm_geometry(const std::string& end);
std::vector<Imperfection> arm_imperfections();

/// The joint of the arm.
Joint arm_joint(const Settings& options);
/// The joint at its end, with the errors of the radius; it does not turn.
Joint end_joint(const Settings& options, const ErrorValues& errors);

}  // namespace tumble::chain
