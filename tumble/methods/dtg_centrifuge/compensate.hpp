#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::dtg_centrifuge {

/// Subtracts D_x(a), D_y(a) from a recording that holds the specific force.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::dtg_centrifuge
