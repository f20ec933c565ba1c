#pragma once

#include "tumble/math/regression/mixed_model/rows.hpp"

/// The variances of a mixed model by restricted maximum likelihood.
namespace tumble::mixed_model {

struct Components {
  VectorXd variances;   ///< s^2, t_c^2
  MatrixXd covariance;  ///< of these
};

/// Variances of greatest restricted likelihood, none below zero, and their covariance (inverse expected information).
///
/// Given     slow  those that are known are held at their variance
/// Throws    Error::bad_data where nothing is left to show the noise
Components restricted_likelihood(const std::vector<SlowNoise>& slow, const Compressed& rows, const VectorXd& residuals);

/// How much of each slow noise the contrasts show, 0 to 1 [1]: mean variance of the rows without what the
/// parameters explain, over that of the rows.
std::vector<double> shown_by_contrasts(const std::vector<SlowNoise>& slow, const Compressed& rows);

}  // namespace tumble::mixed_model
