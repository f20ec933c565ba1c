#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::dtg {

/// D_x(a), D_y(a) taken off a recording that holds the specific force.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::dtg
