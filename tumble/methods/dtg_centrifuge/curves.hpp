#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/dtg_centrifuge/describe.hpp"

namespace tumble::dtg_centrifuge {

/// Adds K and zeta over specific force: the levels as points, the polynomial as a line, with 95 % bands.
///
/// Given     group  of the level quantities in the ledger
void add_curves(const Outcome& outcome, const std::vector<Level>& levels, std::size_t group, const Ledger& ledger,
                Estimate& estimate);

}  // namespace tumble::dtg_centrifuge
