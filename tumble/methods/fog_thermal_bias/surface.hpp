#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/fog_thermal_bias/solve.hpp"

namespace tumble::fog_thermal_bias {

/// The drift since power-on as a surface over temperature and its rate, for a gyro that started at one temperature.
/// The gradient is the one that went with the rate in the test, by a straight line.
///
/// Given     covariance  of the coefficients [SI], one a column of the answer
///           reference   start temperature of the surface [K]; moved into the range of the test
/// Returned  `thermal_map`: cells inside the calibrated range with drift and its standard uncertainty [rad/s]
///           `thermal_points`: for each cell with averages their mean place, the surface there plus the mean residual,
///           and the mean residual, each run less its mean; empty: temperature or rate did not change
std::vector<Table> thermal_surface(const std::vector<Term>& terms, const Answer& answer, const Matrix& covariance,
                                   double reference);

}  // namespace tumble::fog_thermal_bias
