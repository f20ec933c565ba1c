#pragma once

#include <array>

#include "tumble/methods/rlg_north_finder/outputs.hpp"

namespace tumble::rlg_north_finder {

/// Truths of the plan for each output of the problems, in pulses a second: slopes and offset of what the
/// instrument indicates about rest, times the pulses it counts for it.
///
/// Throws Error::bad_input where no instrument of the plan plays a role, or does not count.
std::array<linear::Truth, outputs> truths_of(const Plan& plan);

}  // namespace tumble::rlg_north_finder
