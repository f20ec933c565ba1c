#pragma once

#include "tumble/methods/accelerometer_four_position/reduce.hpp"

namespace tumble::accelerometer_four_position {

/// Adds findings about faults of the positions, about terms that the test hides, and about the polynomials that its
/// temperatures allow.
void add_findings(const Bench& bench, const Reduced& reduced, const Settings& settings, bool measured,
                  Findings& findings);

}  // namespace tumble::accelerometer_four_position
