#pragma once

#include <array>
#include <string>
#include <vector>

#include "tumble/exchange/calibration.hpp"
#include "tumble/units/sentence.hpp"

/// Form of calibration that PX4 and ArduPilot have in common: offset and scale of each axis, and a polynomial over
/// temperature.
namespace tumble::writing {

/// u = (y - t(T) - offset) scale for one axis.
struct AxisCorrection {
  double offset = 0.0;              ///< [u]
  double scale = 1.0;               ///< [1]
  std::vector<double> temperature;  ///< [u/K^k] of T - T_r, power 1 first
  bool calibrated = false;          ///< else the vehicle keeps its own values

  /// The results state the offset: a drift with temperature alone leaves that of the vehicle as it is.
  bool states_offset() const { return calibrated && (offset != 0.0 || temperature.empty()); }
  bool states_scale() const { return states_offset() || (calibrated && scale != 1.0); }
};

/// Corrections of a triad without misalignment. Problems: a polynomial of more than three powers, one without a range.
std::array<AxisCorrection, 3> corrections(const ImuCalibration& calibration, bool gyro, Problems& problems);
bool has_temperature(const std::array<AxisCorrection, 3>& axes);

/// Terms that both carry.
std::vector<std::string> autopilot_terms();

}  // namespace tumble::writing
