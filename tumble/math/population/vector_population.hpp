#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Values of p parameters that a test of one unit gave. A parameter that it did not determine is NaN.
struct UnitVector {
  std::vector<double> values;  ///< [p], each in a unit of its own
  Matrix covariance;           ///< [p x p], the private part (8.2); rows of missing parameters are not read
};

/// Values that a test of a unit gave if it determined only some of the parameters, or only sums of some.
struct ShownOfUnit {
  Matrix combinations;         ///< A [m x p]: each value is the sum of the parameters with these weights
  std::vector<double> values;  ///< [m], each in a unit of its own
  Matrix covariance;           ///< [m x m], the private part (8.2)
  Matrix shared = {};          ///< B [m x k]: signed shift by one sd of each error that units share; empty: none
};

/// Mean and covariance of the true values of a population.
struct VectorPopulation {
  std::vector<double> mean;  ///< [p]
  Matrix mean_covariance;    ///< [p x p], of the mean, the errors that units share included
  Matrix shared;             ///< [p x k]: covariance of the mean's error with each of those errors
  Matrix spread;             ///< T [p x p], of the true values: most likely
  Matrix expected_spread;    ///< T [p x p] with standard deviations (8.33): for the prior of a further unit
  double shrinkage = 0.0;    ///< nu [1] of (8.11); infinite: correlations are not used
  double inflation = 1.0;    ///< c [1] >= 1: how much farther units are from the others than stated (8.17)
  std::size_t units = 0;
};

/// Restricted likelihood by EM, with correlations shrunk towards zero as far as the units predict each other best.
/// Errors that units share are unknowns beside the mean, of variance 1.
///
/// Given:    units [n], n >= 5, of p parameters each and the same number k of shared errors.
/// Throws:   Error::bad_data for fewer units, different numbers of parameters, a parameter that fewer than five units
///           show by itself, a covariance that is not positive semidefinite.
/// Accuracy: with t quantiles of n - 1, intervals of new units hold in 94 to 97 % for p of 6 to 45, also with fewer
///           units than parameters.
/// See:      docs/equations (8.10), (8.11), (8.33).
VectorPopulation vector_population(std::span<const ShownOfUnit> units);
VectorPopulation vector_population(std::span<const UnitVector> units);

/// How a unit's result moves it from the mean of its population: estimate = mean + gain (y_0 - A mean) (8.13).
struct PopulationGain {
  Matrix gain;                 ///< G [p x m]
  Matrix departure;            ///< D [m x m], covariance of y_0 - A mean
  double distance = 0.0;       ///< D [1], squared, of y_0 from A mean
  std::vector<double> solved;  ///< [m], D^-1 (y_0 - A mean)
};

/// Given:    the covariance [p x p] of a unit of the population about its mean; the mean [p]; what the unit's test
///           shows, whose covariance is the whole one; `common` [m x p], covariance of its errors with those of the
///           mean.
/// Throws:   Error::bad_data where D is not positive definite.
/// See:      docs/equations (8.13).
PopulationGain gain_of(const Matrix& prior, const std::vector<double>& mean, const ShownOfUnit& unit,
                       const Matrix& common);

/// p-value [1] of a squared distance over `dimensions` parameters, with the inflation c (8.17); `freedom` [1] where the
/// uncertainty of the result is known with so many degrees of freedom.
double belonging(double distance, std::size_t dimensions, double inflation,
                 double freedom = std::numeric_limits<double>::infinity());

/// A new unit by its own result and its population.
struct VectorInPopulation {
  std::vector<double> values;       ///< [p]
  Matrix covariance;                ///< [p x p]
  double degrees_of_freedom = 0.0;  ///< of Student's t for intervals [1]
  double distance = 0.0;            ///< D [1], squared, of the result from the mean
  double belongs = 1.0;             ///< p-value [1] of D if the unit is of the population
};

/// The population enters as if it were one more test of the unit: what its own test does not show, or shows only in
/// sums, comes from there.
///
/// Given:    the population; what the unit's own test shows; `shared` [m x p], covariance between its errors and those
/// of
///           the mean, which come from errors that both share; empty for none.
/// Throws:   Error::bad_data where numbers of parameters differ, or the covariance is not positive definite.
/// See:      docs/equations (8.13), (8.17).
VectorInPopulation vector_in_population(const VectorPopulation& population, const ShownOfUnit& unit,
                                        const Matrix& shared = {});
/// The unit in its population, if its test determines each of p parameters by itself or not at all (NaN). Given:
/// `shared` [p x p].
VectorInPopulation vector_in_population(const VectorPopulation& population, const UnitVector& unit,
                                        const Matrix& shared = {});

}  // namespace tumble
