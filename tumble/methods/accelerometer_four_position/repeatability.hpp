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

/// The variances of one quantity: of single cells first, then of power-ups where the test distinguishes them.
struct Repeatability {
  std::vector<Unknown> unknown;
  Matrix covariance;  ///< of the variances
};

/// 1 where two cells share a power-up: [cells x cells].
Matrix same_power_up(const Bench& bench);

/// Scatter of the cells of each quantity beyond the known noise, by restricted likelihood: about one mean for each
/// temperature where some were measured more than once, since that does not depend on the polynomial; else about it.
///
/// Given     known  covariance of Stacked::z [n x n]
/// Returned  one for each of Stacked::active
std::vector<Repeatability> repeatabilities(const Bench& bench, const Stacked& all, const Design& design,
                                           const Matrix& known);

/// Columns of the mean at each temperature: [cells x temperatures].
Matrix means_by_temperature(const Bench& bench);

/// What the temperatures differ by from the polynomial, one shift for all cells at a temperature, with the variance of
/// the shift by restricted likelihood. It is in the uncertainty however small it is: a course that is not clearly
/// something else than the polynomial is not clearly the polynomial either.
struct Misfit {
  std::size_t block = 0;  ///< index in Stacked::active
  bool clear = false;     ///< the F test of lack of fit against the repeats gives chance less than 1e-4
  double ratio = 0.0;     ///< F [1]
  Repeatability found;
};

/// The misfits of each quantity against its repeats. Given: covariance [n x n] of Stacked::z.
std::vector<Misfit> misfits(const Bench& bench, const Stacked& all, const Design& design, const Matrix& covariance);

/// Whether some temperature was measured more than once.
bool repeated(const Bench& bench);

}  // namespace tumble::accelerometer_four_position
