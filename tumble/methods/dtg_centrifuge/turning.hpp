#pragma once

#include "tumble/methods/dtg_centrifuge/data.hpp"

/// Whether arm and table turn evenly, by their encoders.
namespace tumble::dtg_centrifuge {

/// Cuts each level and each rest to the part in which both axes turn evenly, with a finding where that is less than the marks
/// and the plan say: marks that are late, or a rig that is slower than planned. Levels of which less than half would remain
/// stay as they are.
void cut_to_even_turning(Test& test);

}  // namespace tumble::dtg_centrifuge
