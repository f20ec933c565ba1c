#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tumble/methods/accelerometer_four_position/sources.hpp"

namespace tumble::accelerometer_four_position {

/// A variance that is not known beforehand.
struct Unknown {
  std::string name;
  Eigen::MatrixXd kernel;  ///< covariance of Stacked::z for a unit of it
  double variance = 0.0;
};

/// The variances of one quantity: of single cells first, then of power-ups where these can be told from them.
struct Found {
  std::vector<Unknown> unknown;
  Eigen::MatrixXd covariance;  ///< of the variances
};

/// 1 where two cells share a power-up.
Eigen::MatrixXd same_power_up(const Bench& bench);

/// What the cells of each quantity scatter by beyond what is known, by restricted likelihood: about one mean for each
/// temperature where some were taken more than once, since that knows nothing of the polynomial; else about it.
///
/// Returned  one for each of Stacked::active
std::vector<Found> repeatabilities(const Bench& bench, const Stacked& all, const Design& design,
                                   const Eigen::MatrixXd& known);

/// Whether some temperature was taken more than once.
bool repeated(const Bench& bench);

}  // namespace tumble::accelerometer_four_position
