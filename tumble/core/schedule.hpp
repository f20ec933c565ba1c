#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/units/sentence.hpp"

namespace tumble {

/// Motion of one axis of the rig during a segment. Temperature and shake are axes like any other. All values in SI of
/// the axis (rad, K, m/s^2).
struct Motion {
  enum class Kind { hold, rate, slew, sine, sweep, random, ramp, dwell };
  Kind kind = Kind::hold;
  double value = 0.0;  ///< hold, dwell: position or temperature; rate, ramp, slew: speed (unsigned for ramp and slew)
  double to = 0.0;     ///< ramp, slew: where it ends
  double amplitude = 0.0;                  ///< sine, sweep
  double frequency = 0.0;                  ///< sine; sweep: where it begins [Hz]
  double to_frequency = 0.0;               ///< sweep: where it ends [Hz], reached logarithmically over the segment
  double phase = 0.0;                      ///< sine [rad]
  std::vector<double> psd_frequency = {};  ///< random [Hz]
  std::vector<double> psd = {};            ///< random, one-sided [unit^2/Hz]
  /// sweep: time in which it comes to to_frequency [s]; 0: the segment. rate with `from`: twice the middle time of the
  /// readings that `from` follows from [s since the segment's beginning]; there an error of the rate changes nothing
  double lasts = 0.0;
  bool continued = false;  ///< the motion of the segment before, which goes on; nothing was commanded
  /// rate, sine: the angle [rad] at the beginning of the segment (sine: of the middle), where the motion was under way
  /// already; recorded, not commanded
  std::optional<double> from = {};
};

/// [unit of the axis] of a random motion over its whole band: the root of the integral of its density, which is
/// straight between its points on logarithmic axes.
double rms_of(const Motion& random);

struct Segment {
  std::string label;
  double duration = 0.0;  ///< [s]
  int run = 1;            ///< which power-up
  std::map<std::string, Motion> axes;
  bool approach = false;  ///< only brings the rig to where the next segment begins: no sample of it is needed
};

/// Where a problem with a segment is: "segment 'up'".
Sentence place_of_segment(const std::string& label);

using Schedule = std::vector<Segment>;

/// A command to one axis: one motion of one segment, with the segments after it in which it is continued.
struct AxisCommand {
  std::size_t segment = 0;         ///< index of the first
  double begin = 0.0;              ///< [s] since the first segment of the run
  double duration = 0.0;           ///< [s] of all its segments
  const Motion* motion = nullptr;  ///< null: the segment does not mention the axis
};

/// All commands to the axis in a run, in order. The run must live as long.
std::vector<AxisCommand> commands_to(const Schedule& run, const std::string& axis);

}  // namespace tumble
