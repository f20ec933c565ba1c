#pragma once

#include "tumble/reduce/compensate.hpp"

namespace tumble::static_bias {

/// Table `regressors`, for `compensate`.
Table covered();

/// Subtracts the bias from the channel `signal`, or the only one of its kind. The standard uncertainty is that of
/// another power-up: u(bias)^2 + s_b^2 with the repeatability s_b where the result has it.
/// Throws Error::bad_data where no channel or several could be meant, and as tumble::compensate.
Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan);

}  // namespace tumble::static_bias
