#pragma once

#include <string>
#include <vector>

#include "tumble/methods/imu_multi_position/fit.hpp"

namespace tumble::imu_multi_position {

/// A change of the bias of a gyro in the course of the test.
struct BiasChange {
  std::size_t gyro = 0;
  bool step = true;           ///< else a drift in proportion to time
  std::size_t from = 0;       ///< rest in Fit::chain, from which on it is another one
  double size = 0.0;          ///< [unit of the gyro] of the step, or of the drift over all rests
  double times = 0.0;         ///< [1] of its standard uncertainty
  double chance = 1.0;        ///< [1] that a sound test shows as much in any gyro
  std::vector<double> shift;  ///< of the parameters of the fit where it is fitted too
};

/// The change of each gyro that the means of the rests show best, where a sound test shows as much once in 20: a step between
/// two rests or a drift, beside bias and sensitivities, by least squares. The noise is that at rest, or the scatter of the
/// rests if that is greater; a stated bias instability makes steps of its own.
///
/// Given: instability  of the gyros [rad/s]; 0: not stated
std::vector<BiasChange> bias_changes(const Rests& rests, const Fit& fit, double instability);

/// The findings about those that a sound test shows once in 10 000. Given: names of the gyros' channels.
Findings about_changes(const std::vector<BiasChange>& changes, const Fit& fit, const Rests& rests,
                       const std::array<std::string, 3>& names);

}  // namespace tumble::imu_multi_position
