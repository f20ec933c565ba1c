#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/math/square.hpp"

/// The observations of a mixed model, each segment turned so that few rows hold all it says.
namespace tumble::mixed_model {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The sufficient statistics of all segments: rows of unit white noise, and what is left within the segments.
struct Compressed {
  MatrixXd design;
  MatrixXd effects;                ///< a column for each known effect
  std::vector<bool> each_segment;  ///< of the effects
  MatrixXd incidence;              ///< rows x segments: what a shift of the segment does
  VectorXd observations;
  std::vector<std::pair<Index, Index>> parts;  ///< first row and number of rows of each segment
  double within_squares = 0.0;                 ///< sum of squares about anything the model could explain
  double within_freedom = 0.0;
};

/// Least scatter about the mean of any segment, per unit weight: white noise, where a segment is at rest. Returned:
/// variance [u^2 s].
double scatter_within(const MixedData& data);

/// The sufficient statistics. Where there are as many segments as parameters, and their means hold all but a tenth of
/// what the observations say of any parameter, the rows are these means: then no weights can change the estimate.
///
/// Given     white  [u sqrt(s)] sd of unit weight, at least roughly
Compressed compress(const MixedData& data, double white);

/// Ordinary least squares and its residuals: where the estimate starts.
std::pair<VectorXd, VectorXd> ordinary(const Compressed& rows);

/// Columns whose outer products sum to the covariance of the known effects.
MatrixXd known_factor(const Compressed& rows);
MatrixXd known_covariance(const Compressed& rows);

}  // namespace tumble::mixed_model
