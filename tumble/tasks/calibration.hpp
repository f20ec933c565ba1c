#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble {

/// Reads the result that the plan names as its calibration, unless it has been read.
/// Throws Error::bad_file where it is no result; Error::bad_input where it is of another instrument than the plan's.
void read_calibration(Plan& plan);

}  // namespace tumble
