#pragma once

#include <optional>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"

namespace tumble::imu_multi_position {

/// Gravity and the Earth, and stated bias instabilities: prior knowledge of a test.
struct Surroundings {
  double gravity = standard_gravity;  ///< [m/s^2]
  double gravity_sd = 0.0;
  Phrase gravity_from;             ///< where it comes from
  std::optional<double> latitude;  ///< [rad]
  /// Bias instabilities as stated [m/s^2], [rad/s]; 0: not stated.
  double accelerometer_instability = 0.0, gyro_instability = 0.0;
};

/// Result of a fit: parameters in the unit of the channels, budget, tables, curves, findings.
Estimate describe(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                  const Surroundings& surroundings);

}  // namespace tumble::imu_multi_position
