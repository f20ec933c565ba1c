#pragma once

#include <string>
#include <vector>

#include "tumble/methods/dtg_centrifuge/lines.hpp"

/// What the plan's rig makes the instruments feel, as lines at the angles that its encoders show.
namespace tumble::dtg_centrifuge {

/// Along the instrument's x and y axes.
struct Seen {
  Phasors force[2];                         ///< [m/s^2]
  Phasors rate[2];                          ///< [rad/s]
  double force_along = 0.0;                 ///< [m/s^2] mean f_Z
  double arm_rate = 0.0, table_rate = 0.0;  ///< [rad/s] as the encoders show them
};

/// Without errors.
Seen seen_of(const RigPowerUp& rig, const Stretch& stretch);

/// One error of a plan's rig, off by one standard deviation.
struct SeenShift {
  std::string source;
  bool each_segment = false;
  std::vector<Seen> seen;  ///< one a stretch given; of the other plans' stretches as without error
};

/// Each error of the rigs of all plans, off by one standard deviation, at the stretches given.
std::vector<SeenShift> shifts_of(const Test& test, const std::vector<const Stretch*>& stretches,
                                 const std::vector<Seen>& nominal);

}  // namespace tumble::dtg_centrifuge
