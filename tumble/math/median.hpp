#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tumble {

/// The middle one of the values in order, of an even number the upper of both; NaN for no values. No value may be NaN.
/// Given: values [u]. Returned: [u].
inline double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace tumble
