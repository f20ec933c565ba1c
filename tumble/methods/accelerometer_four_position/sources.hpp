#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tumble/methods/accelerometer_four_position/design.hpp"

namespace tumble::accelerometer_four_position {

/// What the results of the cells are uncertain by, from one cause.
struct Source {
  std::string name;
  Eigen::MatrixXd covariance;  ///< of Stacked::z
};

/// Adds to the source of that name, or a new one.
void add(std::vector<Source>& sources, const std::string& name, const Eigen::MatrixXd& covariance);

Eigen::MatrixXd sum_of(const std::vector<Source>& sources);

/// White noise (the first), counting and the errors of the rig; these act through the model of the instrument.
///
/// Given  parameters  [SI] what it shows as found so far: plain polynomials by the design's blocks
std::vector<Source> known_sources(const Bench& bench, const Stacked& all, const Design& design,
                                  const std::vector<double>& parameters);

/// Temperatures read wrong by `sd` [K] throughout; `centred` are the coefficients of the design.
void add_thermometer(const Bench& bench, const Stacked& all, const Design& design, const Eigen::VectorXd& centred,
                     double sd, std::vector<Source>& sources);

}  // namespace tumble::accelerometer_four_position
