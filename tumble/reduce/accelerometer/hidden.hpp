#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// What a schedule cannot show, in words.
namespace tumble::accelerometer {

/// By how much a coefficient comes out wrong for a unit of a term that is not in the model. Both in powers of g, so
/// that the number is that of the theory: K_2 shifts by -1 K_pp.
struct Share {
  std::string name;  ///< of the coefficient
  double share = 0.0;
};

/// Least squares of the term on the columns over the segments. `left` is how much of the term (rms) the columns do not
/// take up: 0 where it is hidden altogether.
struct Shares {
  std::vector<Share> of;
  double left = 0.0;
};
Shares shares_of(const Term& hidden, const linear::Solution& solution);

/// "0.68 K_oq goes into third_order_coefficient": each share above 0.02 with its sign, or "" where there is none.
std::string said(const Shares& shares, const Term& hidden);

/// Puts findings of one's own in the place of the engine's about columns left out, and `stands_for` in these words:
/// a column mixed with the scale factor makes it K_1 (1 + 0.75 K_3). `advice` ends the sentence.
void describe_dropped(Normalised& found, const std::string& advice);

/// Takes a parameter out of an estimate, covariance and budget with it; the others are left as they are.
void withhold(const std::string& name, Estimate& estimate);

}  // namespace tumble::accelerometer
