#pragma once

#include <map>
#include <string>
#include <vector>

namespace tumble {

/// What one axis of the rig does during a segment. Temperature and shake are axes like any other. All values in SI of
/// the axis (rad, K, m/s^2).
struct Motion {
  enum class Kind { hold, rate, slew, sine, random, ramp, dwell };
  Kind kind = Kind::hold;
  double value = 0.0;  ///< hold, dwell: position or temperature; rate, ramp, slew: speed (unsigned for ramp and slew)
  double to = 0.0;     ///< ramp, slew: where it ends
  double amplitude = 0.0;                  ///< sine
  double frequency = 0.0;                  ///< sine [Hz]
  double phase = 0.0;                      ///< sine [rad]
  std::vector<double> psd_frequency = {};  ///< random [Hz]
  std::vector<double> psd = {};            ///< random, one-sided [unit^2/Hz]
};

struct Segment {
  std::string label;
  double duration = 0.0;  ///< [s]
  int run = 1;            ///< which power-up
  std::map<std::string, Motion> axes;
};

using Schedule = std::vector<Segment>;

}  // namespace tumble
