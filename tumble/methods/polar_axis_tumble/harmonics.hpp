#pragma once

#include "tumble/core/estimate.hpp"
#include "tumble/reduce/linear/linear.hpp"

namespace tumble::polar_axis_tumble {

/// Names of parameters that hold others too: "D_SS_minus_D_II", "D_F_sum".
void name_combinations(const linear::Solution& solution, Estimate& estimate);

/// With O along the axis, f_I = F sin th and f_S = F cos th, the drift is
///
///   w_d = B0 + S1 sin th + C1 cos th + S2 sin 2th + C2 cos 2th
///
/// for the sense of O in which the test begins, and the same with `_reversed` for the other: linear functions of the
/// parameters, with their covariance. Also the curves of drift over angle.
void add_harmonics(const linear::Solution& solution, Estimate& estimate);

}  // namespace tumble::polar_axis_tumble
