#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tumble/reduce/accelerometer/scale_factor.hpp"

/// Terms that a schedule cannot show by themselves.
namespace tumble::accelerometer {

/// Error of a coefficient for a unit of a term that is not in the model. Both in powers of g, so that the number is
/// that of the theory: K_2 shifts by -1 K_pp.
struct Share {
  std::string name;  ///< of the coefficient
  double share = 0.0;
  double weight = 0.0;  ///< the same [SI of the coefficient/SI of the term]
};

/// Least squares of the term on the columns over the segments.
struct Shares {
  std::vector<Share> of;
  double unexplained = 0.0;  ///< part of the term (rms) that the columns do not absorb; 0: it is hidden completely
};
Shares shares_of(const Term& hidden, const linear::Solution& solution);

/// The columns of a matrix [m x n] scaled to length 1, and their lengths [n]; 1 for a column of zeros.
std::pair<Matrix, std::vector<double>> with_unit_columns(Matrix x);

/// The coefficients that absorb the term, each with its share where that is above 0.02: "bias + K_oq, scale_factor (1 +
/// 0.34 K_oq)"; empty: no coefficient does.
std::string meanings(const Shares& shares, const Term& hidden);

/// States in the parameters of an estimate that they contain the term, where the columns absorb it completely; the
/// scale factor [SI] multiplies its own share.
void state_contained(const Shares& shares, const Term& hidden, double scale_factor, Estimate& estimate);

/// Replaces the engine's findings about columns that are not used, and its `stands_for`, by those of this model: a
/// column mixed with the scale factor makes it K_1 (1 + 0.75 K_3). Given: advice, a key in [phrase].
void describe_dropped(Normalised& fit, const std::string& advice);

/// Removes a parameter from an estimate, from its covariance and budget; the others do not change.
void withhold(const std::string& name, Estimate& estimate);

}  // namespace tumble::accelerometer
