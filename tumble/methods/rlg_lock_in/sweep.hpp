#pragma once

#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"

namespace tumble::rlg_lock_in {

/// One segment of the test: rate of the rig and beat of the gyro.
struct Point {
  std::string label;
  int run = 1;
  bool dithered = false;
  bool moving = false;         ///< an axis turns at a rate
  double rate = 0.0;           ///< nominal mean input rate, the Earth's included [rad/s]
  double spread = 0.0;         ///< rms of the nominal rate about it, from a tilted axis that turns [rad/s]
  double beat = 0.0;           ///< mean beat frequency with its sign [fringe/s]; NaN where predicted
  double duration = 0.0;       ///< [s] of the samples used
  double sample_step = 0.0;    ///< [s]
  std::vector<double> beats;   ///< sample by sample [fringe/s], NaN: missing
  std::vector<double> effect;  ///< change of the rate by one sd of each rig error [rad/s]
};

struct RigEffect {
  std::string source;
  bool each_segment = false;
  std::string key = {};  ///< see KnownEffect
};

struct Sweep {
  std::vector<Point> points;
  std::vector<RigEffect> effects;
  Findings findings;
};

/// The segments of a recorded test.
/// Throws  Error::bad_data, bad_input with what the plan or the recordings lack
Sweep sweep_of(const Evidence& evidence);

/// The segments of a planned test: no beats.
Sweep sweep_of(const Plan& plan);

}  // namespace tumble::rlg_lock_in
