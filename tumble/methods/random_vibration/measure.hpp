#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/math/regression/long_run.hpp"
#include "tumble/math/shaped_noise.hpp"
#include "tumble/reduce/vibration/vibration.hpp"

namespace tumble::random_vibration {

/// Output of the unit at rest, interpolated to the middle of the vibration.
struct Rest {
  double value = 0.0, slope = 0.0;  ///< [m/s^2], [m/s^2/s]
  double variance = 0.0, degrees_of_freedom = 1.0;
  double white = 0.0;                ///< density at zero of one window [(m/s^2)^2]
  double white_freedom = 1.0;        ///< degrees of freedom of it
  double slow_variance = 0.0;        ///< of slow noise in the difference between vibration and rest
  double before = 0.0, after = 0.0;  ///< means [m/s^2]; NaN: none
  bool both_sides = false;
};

/// One unit in one vibration. [m/s^2] throughout.
struct Measured {
  std::size_t unit = 0, series = 0;
  Rest rest;
  std::vector<double> error;    ///< e_j, specific force less that at rest; NaN: missing
  std::vector<double> own;      ///< e_j less the fit of the reference; empty: no reference over the windows
  double mean = 0.0;            ///< of windows that fade in and out
  double plain_mean = 0.0;      ///< docs/equations (3.7)
  double sd = 0.0;              ///< docs/equations (3.7)
  double own_sd = 0.0;          ///< of `own`
  double reference_gain = 0.0;  ///< of the unit against the reference
  double lowest = 0.0, highest = 0.0;
  std::size_t windows = 0;  ///< not missing
  double sense = 1.0;       ///< -1: the input axis looks against the shake
  double per_force = 1.0;   ///< pulses of one window for one m/s^2; 1 where nothing is counted
};

/// One vibration: its units side by side.
struct Exposure {
  std::string label, prefix;  ///< prefix of the parameters: empty where there is only one
  SpectralDensity psd;        ///< [(m/s^2)^2/Hz] as commanded
  double window = 0.0, interval = 0.0, begin = 0.0, end = 0.0;  ///< [s]
  double rms = 0.0;                                             ///< of the vibration [m/s^2], by the plan or measured
  double rms_sd = 0.0;                                          ///< relative
  double level_sd = 0.0;                                        ///< relative, of the vibration about the plan
  double gain_sd = 0.0;                                         ///< relative, of the reference's gain
  /// [1/(m/s^2)] standard deviation of what motion across, coherent with the main motion, adds to the rectification of a unit:
  /// K_ip and K_io times the share of the motion that is across, in both directions.
  std::array<double, 2> across{};
  bool from_reference = false;
  std::vector<double> reference;  ///< [m/s^2] of each window, the first unit's; empty: none
  std::vector<double> weights;    ///< of all windows, that fade in and out; their sum is 1
  std::vector<Measured> units;
};

/// Every random vibration of the data. Throws Error::bad_data, bad_input with everything that is missing.
std::vector<Exposure> exposures_of(const Evidence& evidence, const vibration::Data& data, Findings& findings);

/// Sets moments and extremes of a unit from its `error`. Given: weights of all windows [1].
void set_moments(const std::vector<double>& weights, Measured& m);

/// Highest less lowest error of each of `blocks` equal parts [m/s^2].
std::vector<double> ranges_of_blocks(const std::vector<double>& error, std::size_t blocks);

}  // namespace tumble::random_vibration
