#pragma once

#include <optional>

#include "tumble/core/channel.hpp"
#include "tumble/core/evidence.hpp"

/// Stamps that say when samples arrived, and not when they were taken.
namespace tumble {

/// The even clock behind stamps that come in bursts, as a buffer that is read from time to time gives them. No sample arrives before
/// it was taken: the clock passes through the earliest of its stamps, t_0 = min_i (t_i - i/rate).
///
/// Returned  nothing where the stamps scatter about an even clock without pauses, where samples were lost, or where no even clock explains them
/// See       clock_of
std::optional<Timeline> timeline_of_bursts(const Channel& channel);

/// The recordings, each channel whose stamps come in bursts with the clock behind them; nothing where no channel has such.
std::optional<std::vector<Recording>> with_clocks_of_bursts(const std::vector<Recording>& recordings);

}  // namespace tumble
