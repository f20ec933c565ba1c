#pragma once

#include <array>

#include "tumble/methods/rlg_north_finder/outputs.hpp"

namespace tumble::rlg_north_finder {

/// What the plan's truths say of each output as the problems see it, in pulses a second: slopes and offset of what the
/// instrument indicates about rest, times the pulses it counts for it.
///
/// Throws Error::bad_input where no instrument of the plan plays a role, or does not count.
std::array<linear::Truth, outputs> truths_of(const Plan& plan);

}  // namespace tumble::rlg_north_finder
