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

/// Where the interval of the samples is no multiple of the tick, neighbours are one tick apart or two, and look like an
/// even clock of one tick that loses samples; where it is shorter than the tick, stamps repeat. But then the stamps
/// stay within one tick of a straight line: of all intervals T for which whole numbers x_i of them explain every stamp,
///
///   max(t_i - x_i T) - min(t_i - x_i T) <= 1.1 ticks,   x_{i+1} > x_i,
///
/// the one that leaves the fewest samples out is taken: chance does not place lost samples so evenly.
///
/// Given     t  [s] stamps, none before the one before
/// Returned  nothing where the stamps have no tick, the interval is so near to it that fewer than 8 stamps of the
/// record
///           show the difference, three times as many samples are missing as do, or no interval explains them
std::optional<TickedStamps> ticked(std::span<const double> t);

}  // namespace tumble
