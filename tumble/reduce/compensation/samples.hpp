#pragma once

#include <vector>

#include "tumble/reduce/compensation/inputs.hpp"
#include "tumble/reduce/compensation/work.hpp"

/// All samples of a recording, one after the other.
namespace tumble::compensation {

/// The output that shows the quantity of a slot; the number of outputs where none does.
std::size_t shown_by(const Works& works, std::size_t slot);

/// u of all outputs in the place of what `raw` holds, with their uncertainties and the sizes of the terms in `works`.
/// Where an angular acceleration is needed, the slopes of what the passes before found are taken for it.
void take_all(const Inputs& known, const std::vector<Slot>& slots, const Recording& raw, Works& works,
              Recording& recording);

}  // namespace tumble::compensation
