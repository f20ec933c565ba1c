#pragma once

#include "tumble/methods/accelerometer_four_position/reduce.hpp"

namespace tumble::accelerometer_four_position {

/// What is odd in the positions, what the test hides and what its temperatures allow.
void add_findings(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured,
                  Findings& findings);

}  // namespace tumble::accelerometer_four_position
