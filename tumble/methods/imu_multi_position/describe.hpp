#pragma once

#include <optional>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"

namespace tumble::imu_multi_position {

/// Gravity and the Earth, and stated bias instabilities: prior knowledge of a test.
struct Surroundings {
  double gravity = standard_gravity;  ///< [m/s^2]
  double gravity_sd = 0.0;
  std::string gravity_key = {};    ///< see Contribution
  Phrase gravity_from;             ///< where it comes from
  std::optional<double> latitude;  ///< [rad]
  double latitude_sd = 0.0;        ///< [rad]
  /// Bias instabilities as stated [m/s^2], [rad/s]; 0: not stated.
  double accelerometer_instability = 0.0, gyro_instability = 0.0;
};

/// Result of a fit: parameters in the unit of the channels, budget, tables, curves, findings.
Estimate describe(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                  const Surroundings& surroundings);

/// The nearest of the 6 faces, 12 edges and 8 corners of a cube: "+x", "+x -z", "-x +y -z".
std::string facing(Vector3 up);

/// Reduction of the uncertainties by more rests and turns, from the information they would add.
struct Guidance {
  Table poses;      ///< direction up, rests there, greatest reduction of a sd by one more, and of which parameter
  Table turns;      ///< axis, angle turned about it so far, reduction by a turn of 90 deg; no rows without gyros
  Findings advice;  ///< the three best directions one after the other, the best turn
};

/// `names` of the parameters in the order of the fit. Given: gravity [m/s^2].
Guidance guidance_of(const Fit& fit, const std::vector<std::string>& names, double gravity);

/// Faces, then edges, that no rest shows: "+y, -z, +x -y"; for a test with too few rests.
std::string missing(const std::vector<Vector3>& directions);

/// The error models, with what the accelerometers felt in the rests, the gyros in rests and moves.
std::vector<OutputModel> models_of(const std::vector<Session>& sessions, const Rests& rests, const Fit& fit,
                                   const Estimate& estimate);

}  // namespace tumble::imu_multi_position
