#pragma once

#include "tumble/core/plan.hpp"

namespace tumble {

/// How long a unit that is off needs until it has the temperature of the air, by the slowest time constant tau of the
/// plan's rig (`top_time`, `side_time` of a thermal chamber): the widest step dT of the schedule, from room temperature
/// on and with the heat of the unit itself, has come down to `within`,
///
///   t = tau ln(dT/within)
///
/// Given     within  [K] > 0
///
/// Returned  [s]; 0 where the rig has no chamber, or the schedule does not use it
double soak_time_of(const Plan& plan, double within);

}  // namespace tumble
