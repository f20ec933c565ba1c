#pragma once

#include "tumble/methods/method.hpp"

namespace tumble::dtg_centrifuge {

/// D_x(a), D_y(a) taken off a recording that holds the specific force.
Compensation compensate(const Estimate& estimate, const Recording& recording);

}  // namespace tumble::dtg_centrifuge
