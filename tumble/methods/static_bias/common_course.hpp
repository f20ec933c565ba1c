#pragma once

#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/methods/static_bias/power_on.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::static_bias {

/// A finding where power-ups of one length have a course in common, counted from power-on: a warm-up, a bias that steps, a
/// room whose temperature goes up and down. Noise of one power-up has none with that of another, however slow it is.
///
/// Waves of a half to eight periods, and steps between the tenths of a power-up before and after, are taken from each
/// power-up; their mean is compared with how they scatter between the power-ups.
///
/// Given  unit  in which the size is shown
Findings common_course(const std::vector<Blocks>& power_ups, const Unit& unit);

}  // namespace tumble::static_bias
