#include "tumble/methods/imu_multi_position/chain.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace tumble::imu_multi_position {

Chain::Chain(Eigen::Index parameters, std::size_t pairs)
    : common(Eigen::MatrixXd::Zero(parameters, parameters)),
      right(Eigen::VectorXd::Zero(parameters)),
      own(pairs, Eigen::Matrix2d::Zero()),
      next(pairs, Eigen::Matrix2d::Zero()),
      border(pairs, Eigen::Matrix<double, Eigen::Dynamic, 2>::Zero(parameters, 2)),
      own_right(pairs, Eigen::Vector2d::Zero()) {}

ChainSolution solve(Chain chain, bool whole) {
  ChainSolution out;
  const std::size_t n = chain.own.size();
  std::vector<Eigen::Matrix2d> inverse(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double determinant = chain.own[k].determinant();
    if (!(determinant > 0.0)) return out;
    inverse[k] = chain.own[k].inverse();
    out.log_determinant += std::log(determinant);
    const Eigen::Matrix<double, Eigen::Dynamic, 2> part = chain.border[k].lazyProduct(inverse[k]);
    const Eigen::Matrix<double, Eigen::Dynamic, 2> root =
        chain.border[k].lazyProduct(Eigen::Matrix2d(inverse[k].llt().matrixL()));
    out.gain += chain.own_right[k].dot(inverse[k] * chain.own_right[k]);
    for (int c = 0; c < 2; ++c) {
      chain.common.selfadjointView<Eigen::Lower>().rankUpdate(root.col(c), -1.0);
      chain.right -= chain.own_right[k][c] * part.col(c);
    }
    if (k + 1 == n) break;
    const Eigen::Matrix2d forward = chain.next[k].transpose() * inverse[k];
    chain.own[k + 1] -= forward * chain.next[k];
    chain.own_right[k + 1] -= forward * chain.own_right[k];
    chain.border[k + 1] -= part.lazyProduct(chain.next[k]);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(chain.common);
  if (factor.info() != Eigen::Success) return out;
  for (Eigen::Index i = 0; i < chain.common.rows(); ++i)
    out.log_determinant += 2.0 * std::log(factor.matrixLLT()(i, i));
  out.parameters = factor.solve(chain.right);
  out.gain += out.parameters.dot(chain.right);
  out.sound = out.parameters.allFinite();
  if (!whole) return out;
  out.covariance = factor.solve(Eigen::MatrixXd::Identity(chain.common.rows(), chain.common.rows()));
  out.pairs.resize(n), out.with.resize(n);
  for (std::size_t k = n; k-- > 0;) {
    Eigen::Vector2d right = chain.own_right[k] - chain.border[k].transpose() * out.parameters;
    Eigen::Matrix<double, 2, Eigen::Dynamic> with = -chain.border[k].transpose() * out.covariance;
    if (k + 1 < n) right -= chain.next[k] * out.pairs[k + 1], with -= chain.next[k] * out.with[k + 1];
    out.pairs[k] = inverse[k] * right;
    out.with[k] = inverse[k] * with;
  }
  return out;
}

}  // namespace tumble::imu_multi_position
