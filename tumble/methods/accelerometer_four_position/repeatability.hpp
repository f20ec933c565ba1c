#pragma once

#include <string>
#include <vector>

#include "tumble/methods/accelerometer_four_position/sources.hpp"

namespace tumble::accelerometer_four_position {

/// A variance that is not known beforehand.
struct Unknown {
  std::string name;
  Matrix kernel;  ///< covariance of Stacked::z for a unit of it
  double variance = 0.0;
};

/// Variances of one quantity: of single cells first, then of power-ups where the test distinguishes them, then of what
/// the temperatures differ by from the polynomial where there are repeats and more temperatures than coefficients.
struct Repeatability {
  std::vector<Unknown> unknown;
  Matrix covariance;            ///< of the variances
  std::vector<double> freedom;  ///< see Components
  double misfit = 0.0;          ///< sd by which the temperatures differ from the polynomial [SI]
  double misfit_ratio = 0.0;    ///< F of lack of fit against the repeats [1]
  double misfit_chance = 1.0;   ///< p-value of this F [1]
};

/// 1 where two cells share a power-up: [cells x cells].
Matrix same_power_up(const Bench& bench);

/// Columns of the mean at each temperature: [cells x temperatures].
Matrix means_by_temperature(const Bench& bench);

/// Scatter of the cells of each quantity beyond the known noise, all variances together by restricted likelihood. That
/// of the temperatures about the polynomial is in the uncertainty however small it is: a course that is not clearly
/// something else than the polynomial is not clearly the polynomial either.
///
/// Given     known  covariance of Stacked::z [n x n]
/// Returned  one for each of Stacked::active
std::vector<Repeatability> repeatabilities(const Bench& bench, const Stacked& all, const Design& design,
                                           const Matrix& known);

/// Whether some temperature was measured more than once.
bool repeated(const Bench& bench);

}  // namespace tumble::accelerometer_four_position
