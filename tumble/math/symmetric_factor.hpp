#pragma once

#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// A factor of a symmetric matrix, and how far the matrix is from positive semidefinite.
struct SymmetricFactor {
  Matrix factor;        ///< [u_i] p x q with factor x factor' = matrix, q its rank
  double excess = 0.0;  ///< greatest remainder |matrix - factor x factor'|_ij / sqrt(scale_i scale_j)
};

/// Cholesky factor with complete pivoting, of columns until the rest is rounding.
///
/// Given     matrix  C [u_i u_j], p x p, symmetric
///           scale   [u_i^2] p, what rounding is judged against: the variances of a sum that C is a part of, for
///                   example; empty: the diagonal of C
/// Returned  factor F with F F' = C. The pivots of its columns are positive. An excess above 1e-9 says that C is not
///           positive semidefinite
/// Accuracy  what remains of a diagonal element is below 1e-14 of its scale
/// See       Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), section 10.3
SymmetricFactor symmetric_factor(const Matrix& matrix, std::vector<double> scale = {});

}  // namespace tumble
