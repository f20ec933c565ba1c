#pragma once

#include <memory>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"

/// Turning and oscillating axes, where the encoders of a rig recorded them.
namespace tumble::table {

/// Plans of an evidence with the angles and rates that were recorded.
struct RecordedTurns {
  Plan plan;                                            ///< in place of Evidence::plan
  std::vector<std::shared_ptr<const Plan>> plans = {};  ///< in place of Evidence::plans
  Findings findings = {};  ///< turn_phase_recorded, turn_rate_recorded; empty: the plans may be used as they are, and
                           ///< none is given here
};

/// Channels called <axis>_angle (or named for such a role in [channels]) say at which angle an axis turned or
/// oscillated.
///
/// A plan knows an axis from where it stood before. On a rig that turns before the recording begins the angle is
/// another one: for each segment in which the axis has `rate` or `sine`, Motion::from and the phase are fitted to the
/// readings from where the plan has settled to the end of the segment,
///
///   rate   from = arg sum_i exp(j (th_i - W t_i))
///   sine   th = from + A sin(phase + 2 pi f t)      least squares, see fit_sine
///
/// with t_i since the beginning of the segment. An error of the rate changes the angle before and after the
/// mean of these times, but not there, where the readings give it: Motion::lasts is twice this time. A reading stamped
/// t is that of the middle of its sample, t + 1/(2 rate). It may count turns or not. The plan's own motion remains
/// where it differs from the readings by no more than 0.1 deg, or than the rig errors of the plan explain (six standard
/// deviations of `repeatability_sd`, and of `rate_error_sd` of the way since the axis stood, at most 0.5 rad); and
/// where the readings do not show the commanded motion: residuals above 26 deg, an amplitude off by more than a fifth,
/// less than a period.
///
/// An axis may turn at another rate than the plan says, as one that is off within the tolerance of its station. The
/// slope of th - W t is taken as departure from W where it exceeds six standard deviations of the plan's
/// `rate_error_sd` and of the slope together (which is at least half of the largest step between two readings over
/// their time, because of encoders that resolve little), is at most a hundredth of W, and is the same in both halves of
/// the time: then the rate of the readings is used.
///
/// A segment that several recordings hold with different phases has a plan of its own in each; the errors of the rig
/// are then those of several rigs.
///
/// Neglected effects: the zero of the encoder, which remains in the budget as the rig's `index_zero_sd`; that of the
/// fit itself, of the order of the encoder's noise over the root of the number of readings; an error of the frequency;
/// encoders that read at another time than the middle of a sample, which shifts by rate times that time. What an axis
/// does in a segment that does not mention it, after it turned, still follows from the plan.
RecordedTurns recorded_turns(const Evidence& evidence);

}  // namespace tumble::table
