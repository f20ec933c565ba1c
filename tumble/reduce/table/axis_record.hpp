#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/reduce/order_of_marks.hpp"
#include "tumble/reduce/table/encoders.hpp"

/// One axis over a recording: what its encoder shows of the motions and stands of the plan.
namespace tumble::table {

/// A segment of a plan whose axis was recorded.
struct Turned {
  enum class Other { phase, rate, oscillation, angle };  ///< what is other than planned
  std::size_t segment = 0;
  std::string axis;
  std::optional<Motion> motion = {};  ///< in place of the plan's
  Other other = Other::phase;
  double departure =
      0.0;  ///< rate, oscillation (the greater one of amplitude and frequency): [1] of the plan's; angle [rad]
  bool beyond_rig = false;  ///< beyond what the plan states of its rig and two clocks explain
};

/// One axis and how its recording is read.
struct AxisRecord {
  const Plan& plan;
  const Conducted& test;  ///< as the rig of the plan carries it out, without errors
  const Encoder& encoder;
  const std::vector<PlacedSegment>& places;
};

struct AxisFound {
  std::vector<Turned> turned;  ///< of the segments in which it was recorded
  Findings findings;
};

/// Every motion of the axis in place of which the readings show another one, see recorded_turns. Given: whether the angles
/// at which it stands are compared too.
AxisFound found_of(const AxisRecord& axis, bool with_stands);

}  // namespace tumble::table
