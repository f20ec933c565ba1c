#pragma once

#include <memory>
#include <vector>

#include "tumble/core/evidence.hpp"
#include "tumble/core/finding.hpp"

/// Axes whose motion the encoders of a rig recorded.
namespace tumble::table {

/// Plans of an evidence with the motions that were recorded.
struct RecordedTurns {
  Plan plan;                                            ///< in place of Evidence::plan
  std::vector<std::shared_ptr<const Plan>> plans = {};  ///< in place of Evidence::plans
  Findings findings = {};  ///< what was recorded otherwise; empty: the plans may be used as they are, and none is given
                           ///< here
};

/// Channels called <axis>_angle (or named for such a role in [channels]) say at which angle an axis turned, oscillated or
/// stood.
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
/// t is that of the middle of its sample, t + 1/(2 rate). It may count turns or not. Readings of the moves before and after
/// do not count, see kept_motion. The plan's own motion remains where it differs from the readings by no more than
/// 0.01 deg, or than the rig errors of the plan explain (six standard deviations of `repeatability_sd`, and of
/// `rate_error_sd` of the way since the axis stood, at most 0.5 rad); and where the readings are too few to judge: less
/// than a period, residuals above 26 deg.
///
/// A recorded motion that is not the planned one is used, or is an error that gives both numbers:
///
/// * Rate. The slope of th - W t is a departure from W where it exceeds six standard deviations of the plan's
///   `rate_error_sd` and of the slope together (which is at least half of the largest step between two readings over
///   their time, because of encoders that resolve little) and is the same in both halves of the time. A clock, an
///   encoder and a drive that are off move all rates by one share: where the weighted mean of all segments of the axis shows
///   it, it holds for the slow ones too, which do not show it themselves. The rate of the readings is used, and
///   turn_rate_recorded warns, since no channel shows which of the three is off.
/// * Oscillation. Amplitude and frequency of the readings are used: beyond six standard deviations of `amplitude_sd` and of
///   the fit, and beyond those of the fit. A frequency off by less than two quartz clocks (100 ppm) is no warning.
/// * Angle. An axis that stands elsewhere, by six standard deviations of `repeatability_sd` or by a sum of squares that chance
///   does not give, stands where its encoder shows it, counted from the middle one of its stands: their common part is
///   the zero of the encoder, which a finding names and which is not used. A method with the option `angle_tolerance` does
///   this by itself.
/// * Direction. An encoder that shows every rate and every stand in the other direction is not used (error).
/// * Another motion. A rate, an amplitude or a frequency that is off by a fifth and more, an axis that turns where the plan holds
///   it, and more than a third of the positions elsewhere by a degree: an error; the plan's motion is used.
///
/// A segment that several recordings hold with different phases has a plan of its own in each; the errors of the rig
/// are then those of several rigs.
///
/// Neglected effects: the zero of the encoder, which remains in the budget as the rig's `index_zero_sd`; that of the
/// fit itself, of the order of the encoder's noise over the root of the number of readings;
/// encoders that read at another time than the middle of a sample, which shifts by rate times that time. What an axis
/// does in a segment that does not mention it, after it turned, still follows from the plan.
RecordedTurns recorded_turns(const Evidence& evidence);

}  // namespace tumble::table
