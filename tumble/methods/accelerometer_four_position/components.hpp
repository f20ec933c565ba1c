#pragma once

#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble::accelerometer_four_position {

/// Variances by the restricted likelihood, with their covariance.
struct Components {
  std::vector<double> variance;
  Matrix covariance;
  std::vector<double> freedom;  ///< of the mean square that shows each [1]: the rank of K_c on the contrasts, where
                                ///< that is all of them less the ranks of the others above zero; at least 1
};

/// Variances t_c^2 >= 0 of z = X b + e, Cov e = known + sum_c t_c^2 K_c, by restricted maximum likelihood: that of the
/// contrasts A'z, A'X = 0. A variance that the data put at zero is taken as known: its mean square is pooled with those
/// below it, and the covariance of the others is that of a model without it.
///
/// Given     design        X [n x p] of full rank, p < n
///           observations  z [n]
///           covariance    [n x n] of the known noise
///           kernels       K_c [n x n], of which the contrasts show each
/// See       Patterson and Thompson, Biometrika 58 (1971) 545
Components components_of(const Matrix& design, const std::vector<double>& observations, const Matrix& covariance,
                         const std::vector<Matrix>& kernels);

}  // namespace tumble::accelerometer_four_position
