#include "tumble/methods/accelerometer_four_position/estimator.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// A linear combination of the outputs over s: value and slope, d(u/s) = du/s - (u/s) ds/s.
void set_over_scale(const FourOutputs& weights, const FourOutputs& y, double s, const FourOutputs& slope_of_s,
                    Quantity quantity, FourResults& results) {
  double u = 0.0;
  for (std::size_t k = 0; k < 4; ++k) u += weights[k] * y[k];
  results.value[quantity] = u / s;
  for (std::size_t k = 0; k < 4; ++k)
    results.slope[quantity][k] = (weights[k] - results.value[quantity] * slope_of_s[k]) / s;
}

}  // namespace

FourResults from_two(const FourOutputs& y, double gravity) {
  const double half = 0.5 / gravity, s = (y[0] - y[2]) * half;
  const FourOutputs slope_of_s{half, 0.0, -half, 0.0};
  FourResults results;
  results.value[scale_factor_error] = 1.0 / s - 1.0;
  for (std::size_t k = 0; k < 4; ++k) results.slope[scale_factor_error][k] = -slope_of_s[k] / (s * s);
  set_over_scale({0.5, 0.0, 0.5, 0.0}, y, s, slope_of_s, bias, results);
  return results;
}

FourResults from_four(const FourOutputs& y, double gravity, double sign) {
  FourResults results = from_two(y, gravity);
  const double half = 0.5 / gravity, s = (y[0] - y[2]) * half, square = half / gravity;
  const FourOutputs slope_of_s{half, 0.0, -half, 0.0};
  set_over_scale({0.0, 0.5, 0.0, 0.5}, y, s, slope_of_s, bias, results);
  set_over_scale({square, -square, square, -square}, y, s, slope_of_s, second_order, results);
  set_over_scale({0.0, sign * half, 0.0, -sign * half}, y, s, slope_of_s, misalignment, results);
  return results;
}

}  // namespace tumble::accelerometer_four_position
