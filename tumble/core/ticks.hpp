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
/// even clock of one tick that loses samples. But then the stamps stay within one tick of a straight line: of all
/// intervals T for which whole numbers x_i of them explain every stamp,
///
///   max(t_i - x_i T) - min(t_i - x_i T) <= 1.1 ticks,   x_{i+1} > x_i,
///
/// the one that leaves the fewest samples out is taken: chance does not place lost samples so evenly.
///
/// Given     t  [s] stamps, advancing
/// Returned  nothing where the stamps have no tick, the interval is within 2 % of it (there is nothing to decide) or
///           below, or no interval explains them
std::optional<TickedStamps> ticked(std::span<const double> t);

}  // namespace tumble
