#pragma once

#include <Eigen/Core>

#include "tumble/math/matrix.hpp"

/// Between plain matrices and Eigen's.
namespace tumble {

inline Eigen::Index at(std::size_t i) { return static_cast<Eigen::Index>(i); }

/// A matrix [r x c] as Eigen sees it, without a copy.
inline Eigen::Map<const Eigen::MatrixXd> map(const Matrix& m) { return {m.values.data(), at(m.rows), at(m.columns)}; }

/// A copy [r x c].
inline Matrix plain(const Eigen::MatrixXd& m) {
  Matrix out(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  Eigen::Map<Eigen::MatrixXd>(out.values.data(), m.rows(), m.cols()) = m;
  return out;
}

}  // namespace tumble
