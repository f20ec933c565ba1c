#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"

/// Angles that the encoders of a rig recorded, in place of those that the plan commanded.
namespace tumble::table {

/// Where an axis stood in a segment, or where its move in the segment ended.
struct Stand {
  std::size_t recording = 0;
  std::string label;
  int run = 1;
  std::string axis;
  double commanded = 0.0;  ///< [rad]
  double recorded = 0.0;   ///< [rad] mean of the readings
  double sd = 0.0;         ///< [rad] of the mean, by the scatter and the step of the readings
  double drift = 0.0;      ///< [rad] second half of the rest minus the first
  double drift_sd = 0.0;   ///< [rad] by the scatter and the step of the readings
  bool moving = false;     ///< at the end of its move, where the plan has it at rest
};

struct RecordedAngles {
  /// The recordings, unchanged; each plan has the recorded angles in its `hold` and `slew` motions. Where every axis
  /// that the schedule moves was recorded, the plan's `repeatability_sd` is that of the means of the readings;
  /// `index_zero_sd` and the errors of the scales remain, since an encoder cannot show them.
  Evidence evidence;
  std::vector<Stand> stands;      ///< empty: no angles were recorded
  std::vector<std::string> axes;  ///< whose angles were recorded
  Findings findings;              ///< angle_off_plan, angles_off_in_proportion, axis_not_at_rest, turn_late, turn_early
};

/// Channels called <axis>_angle (or named for such a role in [channels]) replace what the plan commands.
///
/// An axis that a segment does not mention stands where its encoder shows it, if that is farther from the plan than the
/// tolerance. A rest begins `settling` after its axes have settled, by the plan and by the encoder, and ends with the segment or when the
/// encoder shows the next move; after a slew it is the remainder of the segment in which the readings are as the last
/// one, or else the last reading. A slew that is not over in its segment is an error. Readings that do not count turns are taken nearest to the
/// command. Where they count turns, a finding names a slew that passes its middle at another time than the plan says:
/// the turn of the Earth on the way is calculated from the plan.
///
/// Given     settling   [s], as Problem::settling
///           tolerance  [rad] by which a recorded angle may differ from the plan without a warning
RecordedAngles with_recorded_angles(const Evidence& evidence, double settling, double tolerance);

/// Commanded angle of an axis at the end of every segment [rad]; NaN where it turns or oscillates.
std::vector<double> commands_of(const Schedule& schedule, const std::string& axis);

/// Table `angles`: commanded, recorded, difference, sd. Empty rows where nothing was recorded.
Table angles_table(const RecordedAngles& angles);

}  // namespace tumble::table
