#pragma once

#include <array>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble::imu_multi_position {

using Pair = std::array<double, 2>;

/// A matrix [2 x 2]: its rows.
using Matrix2 = std::array<Pair, 2>;

/// Normal equations of p parameters and a chain of pairs of unknowns, each pair tied to its neighbours alone:
///
///   [ C   B_0  B_1 .. ] [ parameters ]   [ right ]
///   [ B_0' D_0  E_0   ] [ pair 0     ] = [ c_0   ]
///   [ B_1' E_0' D_1 ..] [ pair 1     ]   [ c_1   ]
struct Chain {
  struct Link {
    Matrix2 own{}, next{};  ///< D, E
    Matrix border;          ///< B [p x 2]
    Pair right{};           ///< c
  };
  Matrix common;  ///< C [p x p], lower half
  std::vector<double> right;
  std::vector<Link> links;

  Chain(std::size_t parameters, std::size_t pairs);
};

struct ChainSolution {
  std::vector<double> parameters;  ///< [p]
  std::vector<Pair> pairs;
  Matrix covariance;                                      ///< [p x p] of the parameters: their block of the inverse
  std::vector<std::array<std::vector<double>, 2>> cross;  ///< [p] each: blocks of the inverse between pairs and them
  double log_determinant = 0.0;
  double gain = 0.0;  ///< right' inverse right
  bool positive_definite = false;
};

/// Parameters, log determinant and gain by elimination of the pairs one after the other: O(pairs p^2). With
/// `covariances` also the pairs, the covariance of the parameters and its blocks with the pairs.
ChainSolution solve(Chain chain, bool covariances);

}  // namespace tumble::imu_multi_position
