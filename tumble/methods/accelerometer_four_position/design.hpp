#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/methods/accelerometer_four_position/estimator.hpp"
#include "tumble/methods/accelerometer_four_position/positions.hpp"

/// Results of the cells, and the polynomials in the temperature that are fitted to them: (3.6), T in degC.
namespace tumble::accelerometer_four_position {

/// One polynomial among the parameters of all.
struct Polynomial {
  std::size_t first = 0;  ///< index of b_0 (or c_0, or the mean)
  std::size_t count = 0;  ///< order + 1
};

/// T [degC] of `temperature` [K].
double celsius(double temperature);
/// 1, T, T^2 at `temperature` [K].
std::vector<double> powers(double temperature, std::size_t count);
/// P(T) = sum_j p_j T^j at `temperature` [K].
double at_temperature(const std::vector<double>& parameters, const Polynomial& polynomial, double temperature);

/// Results of all cells in one vector z [n], quantity after quantity, and d z/d (output of each stretch) [n x
/// stretches].
struct Stacked {
  std::vector<Quantity> active;
  std::size_t cells = 0;
  std::vector<double> z;
  Matrix slope;

  std::size_t index(std::size_t block, std::size_t cell) const { return block * cells + cell; }
};

/// Every cell by (3.5); `two`: the source's estimator, positions 1 and 3 alone. Throws Error::bad_data where a cell
/// shows no scale factor.
Stacked stacked_of(const Bench& bench, bool two);

/// Powers of the centred and scaled temperature u = (T - T_0)/h; one column for what does not depend on it.
struct Design {
  Matrix x;                         ///< [n x columns]
  std::vector<Polynomial> blocks;   ///< columns of each quantity
  double centre = 0.0, half = 1.0;  ///< T_0, h [K]

  double u(double temperature) const { return (temperature - centre) / half; }  ///< [1]; temperature [K]
};

/// Given  order  highest power of T of the bias and the scale factor error
Design design_of(const Bench& bench, const Stacked& all, std::size_t order);

/// From the centred polynomials to plain ones in T [degC]:
///
///   sum_k beta_k ((T - T_0)/h)^k = sum_j b_j T^j,  b_j = sum_k beta_k/h^k binomial(k, j) (-T_0)^(k - j)
///
/// Returned: [columns x columns]
Matrix to_plain(const Design& design);

}  // namespace tumble::accelerometer_four_position
