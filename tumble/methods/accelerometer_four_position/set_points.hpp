#pragma once

#include <vector>

#include "tumble/methods/accelerometer_four_position/positions.hpp"

namespace tumble::accelerometer_four_position {

/// Measured less commanded temperature [K] of each group of cells, and less what the unit is said to heat itself by; empty: nothing is
/// measured, or the plan has no set points.
std::vector<double> off_set_points(const Bench& bench);

/// By how much the thermometer and the set points differ alike at most temperatures [K], as far as that is more than is stated: the
/// median m of their differences gives sqrt(m^2 - sd^2). Nothing says which of the two is right. 0: no more than sqrt(2) sd.
/// Given: sd  of the thermometer's offset, as stated [K]
double offset_beside_set_points(const Bench& bench, double sd);

/// By how much the thermometer and the set points differ in scale [1], as far as that is more than the scatter of the
/// temperatures about it and than what is stated of the thermometer: the slope s of their difference over the temperature gives
/// sqrt(s^2 - Var s - sd^2). Nothing says which of the two is right. 0: nothing is measured, there are no set points, or no
/// more than that. Given: sd  of the scale, as stated [1]
double scale_beside_set_points(const Bench& bench, double sd);

}  // namespace tumble::accelerometer_four_position
