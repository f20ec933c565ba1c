#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/math/vector3.hpp"
#include "tumble/reduce/imu/sensors.hpp"

/// Calibration of an IMU without a table: moved by hand between rests.
namespace tumble::imu_multi_position {

using imu::letters;

/// Three channels of one kind. Sample i is valid from time[i] to time[i + 1].
struct Triad {
  std::array<std::string, 3> names;
  std::vector<double> time;                                              ///< [s]
  std::vector<Vector3> value;                                            ///< [SI of the unit]; not finite: missing
  std::vector<char> filled;                                              ///< 1: lost, and interpolated
  std::vector<std::size_t> gaps;                                         ///< indices of the last samples before one
  Vector3 lowest{-1e300, -1e300, -1e300}, highest{1e300, 1e300, 1e300};  ///< outputs at which gyros look clipped
  double step = 0.0;                                                     ///< [s] between samples
  bool counts = false;                                                   ///< raw, LSB; else m/s^2 or rad/s

  bool empty() const { return value.empty(); }
  /// First sample at or after that time [s].
  std::size_t index(double instant) const;
  /// Any output of that sample at the end of its range.
  bool clipped(std::size_t sample) const;
};

/// Accelerometers and gyros that were recorded together.
struct Session {
  std::string where;  ///< which recording; empty: there is only one
  Triad accelerometer, gyro;
};

/// The triads of all recordings. A recording with accelerometers alone and one with gyros alone make one session.
/// Throws Error::bad_data that lists every problem: missing or unfit channels, stamps that run backwards, no samples.
std::vector<Session> sessions_of(const Evidence& evidence);

}  // namespace tumble::imu_multi_position
