#pragma once

#include <Eigen/Core>
#include <vector>

#include "tumble/methods/accelerometer_four_position/polynomial.hpp"
#include "tumble/methods/accelerometer_four_position/stacked.hpp"

namespace tumble::accelerometer_four_position {

/// Powers of the centred and scaled temperature u = (T - T_0)/h; one column for what does not depend on it.
struct Design {
  Eigen::MatrixXd x;
  std::vector<Polynomial> blocks;   ///< columns of each quantity
  double centre = 0.0, half = 1.0;  ///< T_0, h [K]

  double u(double temperature) const { return (temperature - centre) / half; }  ///< [1]; temperature [K]
};

/// Given  order  highest power of T of the bias and the scale factor error
Design design_of(const Bench& bench, const Stacked& all, std::size_t order);

/// From the centred polynomials to plain ones in T [degC]:
///
///   sum_k beta_k ((T - T_0)/h)^k = sum_j b_j T^j,  b_j = sum_k beta_k/h^k binomial(k, j) (-T_0)^(k - j)
Eigen::MatrixXd to_plain(const Design& design);

}  // namespace tumble::accelerometer_four_position
