#pragma once

#include <map>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/methods/sine_vibration/measure.hpp"

namespace tumble::sine_vibration {

/// Effect of vibration on the mean of one unit, over all frequencies and levels:
///
///   mean = offset of the power-up + drift t + K_2,eff A^2/2 (+ c A^4) + noise                            (3.12)
///
/// with an offset for each position of the fixture, slow noise that moves whole segments, and a share of K_2,eff that
/// differs from frequency to frequency.
struct Rectification {
  struct Way {
    double rest = 0.0;       ///< a_0 [m/s^2]; NaN: not known
    std::size_t column = 0;  ///< of K_2,eff in `fit`
  };
  std::size_t unit = 0;
  std::vector<Way> ways;  ///< each way the input axis pointed, upwards first
  bool quartic = false;
  std::size_t quartic_column = 0;
  MixedFit fit;
  double between_sd = 0.0;                       ///< [s^2/m] of K_2,eff from frequency to frequency
  double slow_sd = 0.0;                          ///< [m/s^2] by which whole segments differ beyond white noise
  std::map<std::size_t, double> shift_variance;  ///< [m^2/s^4] of Point::shift, by Point::series
  std::map<std::size_t, double> fitted_shift;    ///< [m/s^2] K_2,eff A^2/2 (+ c A^4), by Point::series
};

/// One for each unit whose points have segments at rest to compare with; the others are findings.
std::vector<Rectification> rectify(const vibration::Data& data, const Measured& measured, const std::string& levels,
                                   Findings& findings);

}  // namespace tumble::sine_vibration
