#pragma once

#include <vector>

#include "tumble/math/noise/block_cosines.hpp"

namespace tumble {

/// Fourth difference of t^2 ln t at t and steps of 1, where it is smooth: by its series beyond t = 16.
/// Given: t [steps]. Returned: [1].
double fourth_difference(double t);

/// sum_i w_i w_{i+h} of the weights of cosine `order`, for h = 0 ... radix - 1 [1].
const std::vector<double>& cosine_products(int radix, int order);

}  // namespace tumble
