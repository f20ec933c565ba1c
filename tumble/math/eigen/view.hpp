#pragma once

#include <Eigen/Core>
#include <span>

#include "tumble/math/matrix.hpp"

/// Between plain matrices and Eigen's.
namespace tumble {

inline Eigen::Index at(std::size_t i) { return static_cast<Eigen::Index>(i); }

/// A matrix [r x c] as Eigen sees it, without a copy.
inline Eigen::Map<const Eigen::MatrixXd> map(const Matrix& m) { return {m.values.data(), at(m.rows), at(m.columns)}; }

/// Values [n] as Eigen sees them, without a copy.
inline Eigen::Map<const Eigen::VectorXd> map(std::span<const double> x) { return {x.data(), at(x.size())}; }

/// A matrix [r x c] for Eigen to write to, without a copy.
inline Eigen::Map<Eigen::MatrixXd> view(Matrix& m) { return {m.values.data(), at(m.rows), at(m.columns)}; }

/// A copy [r x c].
inline Matrix plain(const Eigen::MatrixXd& m) {
  Matrix out(static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols()));
  view(out) = m;
  return out;
}

}  // namespace tumble
