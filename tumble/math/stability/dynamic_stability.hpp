#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan.hpp"

namespace tumble {

/// One window of a record.
struct StabilityWindow {
  std::size_t first = 0, size = 0;     ///< samples
  std::vector<DeviationPoint> points;  ///< one for each factor; count 0 where gaps leave too little
};

struct DynamicStability {
  std::vector<std::size_t> factors;   ///< octaves up to an eighth of a window
  std::vector<DeviationPoint> whole;  ///< of the whole record, one for each factor
  std::vector<StabilityWindow> windows;
  // The window and factor that chance explains least:
  std::size_t worst_window = 0, worst_factor = 0;  ///< indices
  double worst_ratio = 1.0;                        ///< its variance over that of the windows that do not overlap it
  double chance = 1.0;    ///< probability of one so far off among all, of a record whose noise does not change
  std::size_t tests = 0;  ///< windows and factors compared
};

/// Overlapping Allan deviation in windows that overlap by half (dynamic Allan deviation), and whether they are alike.
///
/// The variance of each window and factor is compared with the mean of those windows that overlap neither it nor each
/// other, weighted by their edf: F distributed with nu and sum nu_i degrees of freedom if the noise does not change.
/// chance is the least of the two-sided probabilities times their number (Bonferroni), at most 1.
///
/// Given     rate signal [u], NaN: missing; sample_rate [Hz]; windows  their number, 3 and more
/// Throws    Error::bad_input for fewer windows; Error::bad_data if a window has fewer than 32 samples
/// See       L. Galleani and P. Tavella, The dynamic Allan variance, IEEE Trans. UFFC 56 (2009) 450
DynamicStability dynamic_allan(std::span<const double> rate, double sample_rate, std::size_t windows,
                               double confidence);

}  // namespace tumble
