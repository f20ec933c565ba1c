#pragma once

#include "tumble/core/estimate.hpp"

namespace tumble::accelerometer {

/// Specific force from the output y by b_0, b_1, ... and c_0, c_1, ... of a result, or by its bias and
/// scale_factor_error, docs/equations (3.4) for one channel:
///
///   u = (1 + sum_j c_j T^j) y - sum_j b_j T^j,   T in degC
///
/// Given     low, high  [K] temperatures of the test
OutputModel over_temperature(const Estimate& estimate, double low, double high);

}  // namespace tumble::accelerometer
