#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/dtg_centrifuge/describe.hpp"

namespace tumble::dtg_centrifuge {

/// Adds what each level showed in each power-up, less the polynomial through all levels (less its level where there is
/// no polynomial): along X and along Y, or the size where the phase is not known. Bars: 2 sd of the noise within the
/// power-up.
void add_residuals(const Outcome& outcome, const std::vector<Level>& levels, Estimate& estimate);

}  // namespace tumble::dtg_centrifuge
