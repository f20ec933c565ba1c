#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble {

/// Reads the result that the plan names as its calibration, unless it has been read.
/// Throws Error::bad_file where it is no result; Error::bad_input where it is of another instrument than the plan's.
void read_calibration(Plan& plan);

/// The calibration that was used as a setting and as an input with its checksum.
void add_calibration(const Plan& plan, Provenance& provenance);

}  // namespace tumble
