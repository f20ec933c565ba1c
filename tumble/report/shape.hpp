#pragma once

#include "tumble/core/estimate.hpp"

namespace tumble {

/// Every report begins here: an estimate whose parts do not fit together (covariance, budget, ragged tables, curves of
/// unequal length) is a defect of the method that made it.
/// Throws Error::internal with all that does not fit.
void require_shape(const Estimate& estimate);

}  // namespace tumble
