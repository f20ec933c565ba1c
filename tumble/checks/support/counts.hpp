#pragma once

#include <vector>

#include "tumble/core/channel.hpp"

namespace tumble::support {

/// Whether a channel holds pulses.
bool counts_pulses(const Channel& channel);

struct Spread {
  double lowest = 0.0, highest = 0.0;
  bool whole = false;  ///< two samples or more, all of those that are there whole numbers
};
Spread spread_of(const Channel& channel);

/// Values [u] as multiples [1] of the step of a converter; empty where they have none, or are not counted from zero.
///
/// Given     again_least  samples that repeat another one's value: the step is the least difference between two values
std::vector<double> as_counts(const std::vector<double>& values, std::size_t again_least);

}  // namespace tumble::support
