#pragma once

#include <cstddef>
#include <limits>
#include <span>

namespace tumble {

/// Between what values samples lie.
struct Extremes {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -std::numeric_limits<double>::infinity();
  std::size_t present = 0;                    ///< not NaN
  std::size_t at_lowest = 0, at_highest = 0;  ///< samples of these values

  void add(const Extremes& more);
};

/// In one pass, as fast as memory gives the samples. Of 0 and -0, which are equal, either may be the extreme.
/// Given: values [u]; NaN: missing. Returned: extremes [u].
Extremes extremes_of(std::span<const double> values);

/// The greatest step by which a sample stands off both of its neighbours, min(|x_i - x_(i-1)|, |x_i - x_(i+1)|), over
/// begin <= i < end, of those whose neighbours are not missing; 0 without such a sample.
/// Given     values       [u]; NaN: missing
///           begin, end   1 <= begin, end < values.size()
/// Returned  [u]
double greatest_spike(std::span<const double> values, std::size_t begin, std::size_t end);

}  // namespace tumble
