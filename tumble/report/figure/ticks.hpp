#pragma once

#include <string>
#include <vector>

namespace tumble::figure {

/// Where an axis begins and ends, and its ticks. Numbers in the unit of the axis.
struct Ticks {
  double lower = 0.0, upper = 1.0;
  bool logarithmic = false;
  std::vector<double> at;
  std::vector<std::string> labels;  ///< one for each of `at`
  std::vector<double> minor;        ///< without a label
  int exponent = 0;                 ///< power of ten that all labels lack

  /// Place of a value [u] along the axis [1]: 0 at `lower`, 1 at `upper`.
  double place(double value) const;
};

/// Ticks at 1, 2 or 5 times a power of ten, the ends of the axis a little outside of the values.
///
/// Given     low, high  smallest and largest value [u]; equal values get an axis about them
///           most       ticks there is room for
Ticks linear_ticks(double low, double high, int most);

/// Ticks at the powers of ten, at 1, 2, 5 of each where there are few of these, and as on a linear axis below a ratio
/// of 4.
///
/// Given     low, high  smallest and largest value, above zero [u]
///           most       ticks there is room for
Ticks logarithmic_ticks(double low, double high, int most);

/// "10⁻⁵", in characters that need no markup.
std::string power_of_ten(int exponent);

}  // namespace tumble::figure
