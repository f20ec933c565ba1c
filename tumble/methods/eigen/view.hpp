#pragma once

#include <Eigen/Core>

#include "tumble/math/matrix.hpp"

/// Between plain matrices and Eigen's, for the .cpp files of methods.
namespace tumble::methods {

inline Eigen::Index at(std::size_t i) { return static_cast<Eigen::Index>(i); }

inline Eigen::Map<const Eigen::MatrixXd> map(const Matrix& m) { return {m.values.data(), at(m.rows), at(m.columns)}; }

inline Matrix plain(const Eigen::MatrixXd& m) {
  Matrix out(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  Eigen::Map<Eigen::MatrixXd>(out.values.data(), m.rows(), m.cols()) = m;
  return out;
}

}  // namespace tumble::methods
