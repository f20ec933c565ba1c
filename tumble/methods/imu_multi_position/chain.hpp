#pragma once

#include <array>
#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble::imu_multi_position {

/// Normal equations of p parameters and a chain of n unknowns, each of which is tied to the three after it at most:
///
///   [ C    B      ] [ parameters ]   [ right       ]
///   [ B'   D      ] [ unknowns   ] = [ chain_right ]       D_(k, k+j) = band[k][j]
struct Chain {
  static constexpr std::size_t width = 4;
  Matrix common;              ///< C [p x p], lower half
  std::vector<double> right;  ///< [p]
  Matrix border;              ///< B [p x n]
  std::vector<std::array<double, width>> band;
  std::vector<double> chain_right;  ///< [n]

  Chain(std::size_t parameters, std::size_t unknowns);
};

struct ChainSolution {
  std::vector<double> parameters;  ///< [p]
  std::vector<double> unknowns;    ///< [n]
  Matrix covariance;               ///< [p x p] of the parameters: their block of the inverse
  Matrix cross;                    ///< [p x n] block of the inverse between parameters and unknowns
  double log_determinant = 0.0;
  double gain = 0.0;  ///< right side' inverse right side
  bool positive_definite = false;
};

/// Parameters, log determinant and gain by elimination of the unknowns one after the other: O(n p^2). With
/// `covariances` also the unknowns, the covariance of the parameters and that between both.
ChainSolution solve(Chain chain, bool covariances);

/// to += factor * what [u], vectors [n]; `what` may be longer.
inline void add_scaled(std::span<double> to, double factor, std::span<const double> what) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * what[i];
}

}  // namespace tumble::imu_multi_position
