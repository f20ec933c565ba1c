#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/channel.hpp"

namespace tumble {

/// Facts that the stamps of a channel show about the clock behind them.
struct Clock {
  /// A pause after which the count of samples has fallen behind: samples were lost in it.
  struct Gap {
    std::size_t after = 0;  ///< index of the last sample before it
    double begin = 0.0;     ///< [s] its stamp
    double length = 0.0;    ///< [s] to the next stamp
    std::size_t lost = 0;   ///< samples
  };
  double rate = 0.0;            ///< [Hz] while it runs: without the gaps; 0: not known
  double jitter_rms = 0.0;      ///< [s] of the stamps about even spacing at `rate`, without the gaps
  double worst = 0.0;           ///< [s] the greatest such departure
  double longest_pause = 0.0;   ///< [s] between neighbours with nothing lost
  std::size_t pause_after = 0;  ///< index of the sample before it
  std::vector<Gap> gaps;
  std::size_t duplicates = 0;      ///< stamps equal to the one before
  std::size_t backward = 0;        ///< stamps before the one before
  std::size_t first_backward = 0;  ///< index of the first of these
  double rate_change =
      0.0;  ///< greatest departure of the rate from its mean over a sixteenth of the record, 1; 0 where small
  /// [Hz] Another rate that explains stamps of a coarse clock about as well, with other samples lost; 0: none.
  double other_rate = 0.0;
  double scatter = 0.0;  ///< rms of the time that `scatter_samples` samples take, as a part of it; 0 where small
  std::size_t scatter_samples = 0;
  bool even = false;   ///< the samples may be treated as evenly spaced at `rate`
  std::string reason;  ///< why, or why not, in words
};

/// Whether the samples of a channel may be treated as evenly spaced, for stamps of any kind.
///
/// Stamps are often written when samples arrive, not when they are taken: samples that wait in a buffer arrive in
/// bursts, and the stamps scatter about an even clock without drifting off it. A lost sample shifts all later stamps
/// for good. So the departure r_i = t_i - t_0 - i T of the stamps from even spacing (T: median of the mean interval
/// over 64 parts, or the interval that most neighbours keep to) shows the difference: at each long interval, the least
/// r after it is compared with the least r before it, over as many samples as a backlog of that length needs to come
/// through. A sample can be late, never early, so the least r is the true clock. A rise by three quarters of T or more,
/// and beyond what the least r does elsewhere, is a gap.
///
/// Stamps of a coarse clock, whose tick is not far below the interval, or above it, are counted otherwise; see ticked.
/// A row that is written twice, with the stamp and the value of the row before, counts once.
///
/// The rate is the slope of straight lines through the stamps with the lost samples counted, one slope for all. Where
/// the phase after a gap differs from that before it, the logger was stopped and started again: a new line begins
/// there.
///
/// Even means: no gap, no backward stamp, the time taken by 256 samples (a quarter of the record, if shorter) within
/// 3 % rms of its mean, and the rate over each sixteenth of the record within 1 % of the mean rate.
///
/// Given     channel   uniform, or with stamps [s]; a rate beside the stamps is the one that the plan states, and
///                     decides where they do not
/// Returned  see Clock; a uniform channel is even by definition
Clock clock_of(const Channel& channel);

}  // namespace tumble
