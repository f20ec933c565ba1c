#pragma once

#include <array>
#include <string>
#include <vector>

#include "tumble/reduce/linear/linear.hpp"

/// Positions and rotations of the path among the segments of the test, by the specific force and the rate of the plan.
namespace tumble::rlg_north_finder {

/// A rotation about a body axis, all of its segment.
struct Turning {
  std::size_t segment = 0;  ///< in the output's segments
  int axis = 0;             ///< body x, y, z
  double turns = 0.0;       ///< signed; whole if the plan is sound, except for the turn of the Earth meanwhile
  double beyond = 0.0;      ///< [rad] against the ground, more than whole turns: by hand
  double seconds = 0.0;
};

struct Path {
  /// Rests by the body axis that is upright, up and down; indices of segments in order of time.
  std::array<std::vector<std::size_t>, 3> up, down;
  std::vector<Turning> rotations;  ///< empty for an output that has rests only

  const Turning* rotation(int axis, bool forward) const;  ///< the first of that sense, or null
};

Path path_of(const std::vector<linear::SegmentSummary>& segments);

/// Positions and rotations that the path lacks, and the parameters that the formulas cannot determine without them.
Findings missing(const Path& path, Finding::Severity severity);

/// Rotations that are not whole turns by the plan, or by the angles recorded; numbers of turns, forward and reverse,
/// that differ: errors.
Findings not_whole(const Path& path, const std::vector<linear::SegmentSummary>& segments);

}  // namespace tumble::rlg_north_finder
