#pragma once

#include <cmath>
#include <numbers>

namespace tumble {

/// Probability [1] that a standard normal number is above x [1], with full relative accuracy in the tail.
inline double normal_above(double x) { return 0.5 * std::erfc(x / std::numbers::sqrt2); }

/// Probability [1] that a standard normal number is below x [1], with full relative accuracy in the tail.
inline double normal_below(double x) { return normal_above(-x); }

}  // namespace tumble
