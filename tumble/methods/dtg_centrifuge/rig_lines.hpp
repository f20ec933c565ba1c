#pragma once

#include <string>
#include <vector>

#include "tumble/methods/dtg_centrifuge/lines.hpp"
#include "tumble/reduce/rig_effects.hpp"

/// Rate and force on the plan's rig, as lines at the angles that its encoders show.
namespace tumble::dtg_centrifuge {

/// Lines along the instrument's x and y axes.
struct RigLines {
  Phasors force[2];                         ///< [m/s^2]
  Phasors rate[2];                          ///< [rad/s]
  double force_along = 0.0;                 ///< [m/s^2] mean f_Z
  double arm_rate = 0.0, table_rate = 0.0;  ///< [rad/s] of the drives
};

/// Lines on a rig without errors.
RigLines rig_lines_of(const Test& test, const Spin& spin);

/// One error of a plan's rig, off by one standard deviation, and the lines at the spins given with it.
using RigLinesShift = WithError<RigLines>;

/// Keys of errors, one a shift: another test with the key has the same error, see key_of of reduce/rig_effects.
std::vector<std::string> keys_of(const Test& test, const std::vector<RigLinesShift>& shifts);

/// Each error of the rigs of all plans, off by one standard deviation, at the spins given.
std::vector<RigLinesShift> shifts_of(const Test& test, const std::vector<const Spin*>& spins,
                                     const std::vector<RigLines>& nominal);

}  // namespace tumble::dtg_centrifuge
