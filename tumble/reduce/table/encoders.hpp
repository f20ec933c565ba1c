#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/reduce/stretches.hpp"

/// Angles that the encoders of a rig recorded, and the segments of the plan in which they did.
namespace tumble::table {

/// A segment of a schedule and where it was recorded [s, recording's clock].
struct PlacedSegment {
  std::size_t segment = 0;  ///< in the schedule
  double begin = 0.0, settled = 0.0, end = 0.0;
};

/// Where the segments of the plan are in a recording. A run that the schedule lacks has no planned angles.
/// Given: settled [s] after the beginning of each segment of the schedule.
std::vector<PlacedSegment> places_of(const std::vector<MarkedSegment>& marks, const std::vector<double>& settled);

/// One axis in one recording.
struct Encoder {
  std::string axis;
  const Channel* channel = nullptr;
  bool counts_turns = false;
  double step = 0.0;  ///< resolution [rad]: the smallest change between readings; 0 where it is not visible
};

/// The channels called <axis>_angle, or named for such a role in [channels].
std::vector<Encoder> encoders_of(const Evidence& evidence, std::size_t recording);

/// Null: the segment does not mention the axis.
const Motion* motion_of(const Segment& segment, const std::string& axis);

/// Whether [[recording]] calls a recording the file of one segment.
bool recorded_alone(const Evidence& evidence, std::size_t recording);

}  // namespace tumble::table
