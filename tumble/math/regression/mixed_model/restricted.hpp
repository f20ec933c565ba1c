#pragma once

#include "tumble/math/regression/mixed_model/rows.hpp"

/// The variances of a mixed model by restricted maximum likelihood.
namespace tumble::mixed_model {

struct Components {
  VectorXd variances;   ///< s^2, t_c^2
  MatrixXd covariance;  ///< of these
};

/// Variances of greatest restricted likelihood, none below zero, and their covariance (inverse expected information).
/// Throws Error::bad_data where nothing is left to tell the noise.
Components restricted_likelihood(const MixedData& data, const Compressed& rows, const VectorXd& residuals);

}  // namespace tumble::mixed_model
