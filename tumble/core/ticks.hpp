#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace tumble {

/// Samples of an even clock whose stamps were taken from a coarse one (a system timer of 10 ms, 1/64 s).
struct TickedStamps {
  double tick = 0.0;      ///< [s] all intervals are multiples of it, within a tenth
  double interval = 0.0;  ///< [s] between the samples
  /// Index of the last sample before each gap, and how many samples are missing in it.
  std::vector<std::pair<std::size_t, std::size_t>> gaps;
};

/// Result of looking at the stamps of a coarse clock.
struct Ticks {
  std::optional<TickedStamps> stamps;  ///< none: the interval is no other than the tick, or there is no tick
  /// [s] Another interval that explains the stamps about as well; 0: no other interval does.
  double other_interval = 0.0;
};

/// Where the interval of the samples is no multiple of the tick, neighbours are one tick apart or two, and look like an
/// even clock of one tick that loses samples; where it is shorter than the tick, stamps repeat. But then the stamps
/// stay within half a tick of a straight line: of all lines a + x T for which whole numbers x_i explain every stamp,
///
///   |t_i - a - x_i T| <= 0.505 ticks, or, if no line does, 0.55,   x_{i+1} > x_i,
///
/// the one that misses samples the fewest times is taken. It is found from the longest stretches that a line explains
/// without a lost sample: there it is known so well that the next lost sample shows at once. Where samples are lost
/// more often, it is found from the ticks that are empty or doubled at regular distances (comb.hpp).
///
/// A line needs evidence (strip.hpp): steps of two ticks at regular distances come from it, lost samples come anywhere.
/// Where few steps show the difference a stated interval that fits decides, else the interval is the tick.
///
/// Given     t       [s] stamps, none before the one before
///           stated  [s] the interval that the plan states, or 0
Ticks ticked(std::span<const double> t, double stated = 0.0);

/// ticked() for stamps [s] of which some belong to rows that were written twice, without these; the gaps are at their
/// places in `t`.
Ticks ticked_once(std::span<const double> t, double stated = 0.0);

}  // namespace tumble
