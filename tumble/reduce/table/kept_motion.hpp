#pragma once

#include "tumble/core/recording.hpp"
#include "tumble/core/schedule.hpp"
#include "tumble/reduce/table/encoders.hpp"

/// From when to when an axis did what it was to do in a segment, as its encoder shows.
namespace tumble::table {

struct Kept {
  double from = 0.0, until = 0.0;  ///< [s, recording's clock]
};

/// A segment may begin in the move before it (a rig slower than its plan) and end in the next one (a mark that is set late).
///
/// The motion is fitted to a third of the readings, the middle one or else another that holds it: an angle and a rate, an
/// oscillation of free frequency. From there on it is kept, in both directions, up to three readings in succession that do not lie
/// on it, and one reading less.
/// A reading lies on it within 20 arcsec (2 arcsec where the third holds a turn), three steps of the encoder, and six standard deviations of the
/// readings about the fit and of the fit there.
///
/// Given     motion      of the axis in the segment; null: it stands
///           begin, end  [s, recording's clock] when the plan's motion is reached, and the end of the segment
/// Returned  begin and end where all readings lie on the motion, or where it cannot be judged: fewer than five readings
///           in a third, motions of other kinds, no motion of that form
Kept kept_motion(const Encoder& encoder, const Motion* motion, double begin, double end);

}  // namespace tumble::table
