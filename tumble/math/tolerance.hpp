#pragma once

#include <cmath>
#include <limits>

namespace tumble {

/// Limits of what is accepted [u]; either may be infinite. Empty where lower > upper.
struct Tolerance {
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();

  /// Whether a value [u] lies within the limits.
  bool holds(double value) const { return lower <= value && value <= upper; }
  bool empty() const { return lower > upper; }
  bool two_sided() const { return std::isfinite(lower) && std::isfinite(upper); }
};

}  // namespace tumble
