#pragma once

#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"

namespace tumble::fog_thermal_bias {

/// One error finding for each temperature channel that shows one reading for 5 min or more of a run while
///
///   the other sensor moves by 3 K or more (and by 24 steps of its readings),
///   or, where there is one sensor, the reading jumps by 1 K (8 steps) at the end, or changed by as much in the minute
///   before and had noise: heat does not stop at once.
Findings stuck_sensors(const Evidence& evidence);

}  // namespace tumble::fog_thermal_bias
