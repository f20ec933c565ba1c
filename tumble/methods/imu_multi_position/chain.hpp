#pragma once

#include <Eigen/Core>
#include <vector>

namespace tumble::imu_multi_position {

/// Normal equations of p parameters and a chain of pairs of unknowns, each pair tied to its neighbours alone:
///
///   [ C   B_0  B_1 .. ] [ parameters ]   [ right ]
///   [ B_0' D_0  E_0   ] [ pair 0     ] = [ c_0   ]
///   [ B_1' E_0' D_1 ..] [ pair 1     ]   [ c_1   ]
struct Chain {
  Eigen::MatrixXd common;  ///< C, lower half
  Eigen::VectorXd right;
  std::vector<Eigen::Matrix2d> own;                              ///< D
  std::vector<Eigen::Matrix2d> next;                             ///< E
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 2>> border;  ///< B, p x 2
  std::vector<Eigen::Vector2d> own_right;                        ///< c

  Chain(Eigen::Index parameters, std::size_t pairs);
};

struct ChainSolution {
  Eigen::VectorXd parameters;
  std::vector<Eigen::Vector2d> pairs;
  Eigen::MatrixXd covariance;                                  ///< of the parameters: their block of the inverse
  std::vector<Eigen::Matrix<double, 2, Eigen::Dynamic>> with;  ///< the blocks of the inverse between pairs and them
  double log_determinant = 0.0;
  double gain = 0.0;   ///< right' inverse right
  bool sound = false;  ///< positive definite
};

/// Eliminates the pairs one after the other: O(pairs p^2). `whole`: with covariances.
ChainSolution solve(Chain chain, bool whole);

}  // namespace tumble::imu_multi_position
