#pragma once

#include <cstddef>
#include <vector>

/// Polynomials in the temperature, as (3.6) has them: T in degC.
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

}  // namespace tumble::accelerometer_four_position
