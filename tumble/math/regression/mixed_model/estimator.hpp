#pragma once

#include <Eigen/Cholesky>

#include "tumble/math/regression/mixed_model/rows.hpp"

namespace tumble::mixed_model {

/// The linear estimator b = G y for a covariance V of the compressed observations, from the QR of the whitened design
/// with unit columns: V^-1/2 X = Q R D, G = D^-1 R^-1 Q' V^-1/2.
struct Estimator {
  MatrixXd gain;              ///< G, p x n
  Eigen::LLT<MatrixXd> root;  ///< of V
  MatrixXd inner;             ///< (V^-1/2)' Q, n x p
  double condition = 1.0;
};

Estimator estimator(const MatrixXd& design, const MatrixXd& covariance);

}  // namespace tumble::mixed_model
