#pragma once

#include <vector>

#include "tumble/archive/statistics/occasions.hpp"

namespace tumble::statistics {

/// Takes the errors of rigs that results do not name as those of one rig: they go from the private parts of values and
/// occasions to the shared errors, which widens the mean and leaves the spread to the units. Each number `sources` goes
/// by one result that has it. Simulated results are left as they are: a seed draws all errors anew.
/// Returned: whether there are such errors.
bool share_unstated_rigs(PastResults& results, std::vector<Occasion>& occasions, SharedBySource& errors);

}  // namespace tumble::statistics
