#pragma once

#include "tumble/reduce/compensation/work.hpp"

namespace tumble::compensation {

/// Table `compensation`: of each output and power-up the sd before and after, and which share of it was outside of what
/// the calibration covered. Where a thermal model was found from means over a time, the sd is that of such means.
/// Given: `raw` as recorded and `done` as compensated.
Table before_and_after(const Works& works, const Recording& raw, const Recording& done);

}  // namespace tumble::compensation
