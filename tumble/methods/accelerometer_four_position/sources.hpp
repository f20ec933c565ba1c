#pragma once

#include <string>
#include <vector>

#include "tumble/methods/accelerometer_four_position/design.hpp"

namespace tumble::accelerometer_four_position {

/// Uncertainty of the results of the cells from one cause.
struct Source {
  std::string name;
  Matrix covariance;     ///< [n x n] of Stacked::z
  Matrix shifts = {};    ///< n x 1, of one error: shift by one standard deviation; empty: several errors
  std::string key = {};  ///< of one error, see SourceCovariance
};

/// Adds a covariance [n x n] of Stacked::z to the source of that name that has no shifts, or a new one.
void add(std::vector<Source>& sources, const std::string& name, const Matrix& covariance);

/// Covariance [n x n] of Stacked::z from all sources.
Matrix sum_of(const std::vector<Source>& sources);

/// White noise (the first), counting and the errors of the rig; these act through the model of the instrument.
///
/// Given  parameters  [SI] of a first fit: plain polynomials by the design's blocks
std::vector<Source> known_sources(const Bench& bench, const Stacked& all, const Design& design,
                                  const std::vector<double>& parameters);

/// The effect of temperatures that all have an error of `sd` [K], and of a scale of the thermometer that is another one than
/// that of the set points; `centred` are the coefficients of the design.
void add_thermometer(const Bench& bench, const Stacked& all, const Design& design, const std::vector<double>& centred,
                     double sd, std::vector<Source>& sources);

}  // namespace tumble::accelerometer_four_position
