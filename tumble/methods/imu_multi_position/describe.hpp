#pragma once

#include <optional>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::imu_multi_position {

/// What is known of gravity and the Earth besides the recording.
struct Surroundings {
  double gravity = standard_gravity;  ///< [m/s^2]
  double gravity_sd = 0.0;
  std::string gravity_from;        ///< "stated", "normal gravity at the site"
  std::optional<double> latitude;  ///< [rad]
  /// Bias instabilities as stated [m/s^2], [rad/s]; 0: not.
  double accelerometer_instability = 0.0, gyro_instability = 0.0;
};

/// The answer of a fit: parameters in the unit of the channels, budget, tables, curves, findings.
Estimate describe(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                  const Surroundings& surroundings);

}  // namespace tumble::imu_multi_position
