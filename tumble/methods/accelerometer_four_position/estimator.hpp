#pragma once

#include <array>
#include <cstddef>

/// Closed forms for four positions: docs/equations (3.5) in units of the reference scale factor, y = E/K_m [m/s^2].
namespace tumble::accelerometer_four_position {

/// Results of four positions, in this order.
enum Quantity : std::size_t { bias, scale_factor_error, second_order, misalignment, quantities };

/// Means in the positions of figure 11: 1 axis up, 2 level, 3 down, 4 level and turned over against 2.
using FourOutputs = std::array<double, 4>;

struct FourResults {
  std::array<double, quantities> value{};       ///< nabla or K_0 [m/s^2], dK, K_2 [1/(m/s^2)], theta [rad]
  std::array<FourOutputs, quantities> slope{};  ///< d value/d y
};

/// s = (y_1 - y_3)/(2 G) = K_i/K_m,  dK = 1/s - 1,  nabla = (y_1 + y_3)/(2 s)                              (3.5)
///
/// from positions 1 and 3 alone, as the source has it. With terms of higher order K_i = K_1 (1 + K_3 G^2) and
/// nabla = (K_0 + K_2 G^2)/(1 + K_3 G^2).
///
/// Given  outputs y and gravity G [m/s^2]
FourResults from_two(const FourOutputs& y, double gravity);

/// From all four:
///
///   K_0 = (y_2 + y_4)/(2 s),  K_2 = (y_1 + y_3 - y_2 - y_4)/(2 s G^2),  theta = sign (y_2 - y_4)/(2 s G)
///
/// Given  outputs y and gravity G [m/s^2]
///        sign  +1: theta_t, with p up in position 2; -1: theta_p, with t (= o) up in position 2
FourResults from_four(const FourOutputs& y, double gravity, double sign);

}  // namespace tumble::accelerometer_four_position
