#pragma once

#include <string>

#include "tumble/core/estimate.hpp"
#include "tumble/core/plan.hpp"

namespace tumble {

/// Sources of an answer in its plan: the texts of the plan and of the plans of its recordings, the settings of the
/// method as resolved, the channels by role, the values of `--set`, and the calibration with its checksum.
Provenance provenance_of(const Plan& plan);

/// The name of a file from the folder of the plan; as it is where there is no plan.
std::string relative_to(const Plan& plan, const std::string& file);

}  // namespace tumble
