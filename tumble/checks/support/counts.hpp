#pragma once

#include "tumble/core/channel.hpp"

namespace tumble::support {

/// Whether a channel holds pulses.
bool counts_pulses(const Channel& channel);

struct Spread {
  double lowest = 0.0, highest = 0.0;
  bool whole = false;  ///< two samples or more, all of those that are there whole numbers
};
Spread spread_of(const Channel& channel);

}  // namespace tumble::support
