#pragma once

#include <vector>

#include "tumble/reduce/vibration/vibration.hpp"

/// Lost and added pulses, and knocks: windows that what else was recorded does not explain.
namespace tumble::random_vibration {

/// Values as the sum of a reference and its neighbours, each times a gain, and a constant.
struct Explained {
  std::vector<double> residual;  ///< [u of the values]; NaN where values or reference are missing; empty: no fit
  double gain = 0.0;             ///< [1] sum of the gains
};
/// Given: reference, values [u]; lags, neighbours on either side [1].
Explained explained(const std::vector<double>& reference, const std::vector<double>& values, int lags);

/// Skips (NaN) windows that are far off (vibration::outliers_of): at rest about a straight line, in vibration about the
/// reference over the windows, or without one about the other units; there both units of a pair skip the window. One
/// unit alone without a reference shows nothing in its motion. Findings say so.
/// Given: lags of the reference [1].
void skip_outliers(int lags, vibration::Data& data);

}  // namespace tumble::random_vibration
