#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/reduce/vibration/windows.hpp"

namespace tumble::vibration {

/// One unit in one recording, with the values of its channel still as they are.
struct Draft {
  const Channel* channel = nullptr;
  Windows windows;
  std::vector<std::size_t> series;  ///< in Data::series
  std::vector<std::size_t> first;   ///< sample with which each begins
};

/// Counts of segments that vibrate put right where the register ran over, while they are counts still. At rest it does
/// not: their mean says about what the others lie. Where it cannot be told, a problem.
void unwrap_counts(const Settings& settings, const Draft& draft, Data& data, std::vector<std::string>& problems);

/// Counts at rest that grow by a pulse and more from window to window are a running total: a problem.
void refuse_totals(const Draft& draft, const Data& data, std::vector<std::string>& problems);

/// Takes out segments that shake in which a unit gives the same value throughout, or for a long time on end: dead, or
/// not connected. With them go those at rest in which it stands at the value at which it died.
void drop_dead(Data& data);

/// A finding for each unit that shows another specific force at rest than the plan's rig lets expect, by 0.1 g and
/// more.
void compare_rests(Data& data);

/// Takes out segments planned at rest in which the unit moves, as while the shaker runs up: the spread is 20 times that
/// of the unit's quietest, and more than three pulses or a thousandth of the mean. Values are still those of the
/// channel.
void drop_moving(const std::map<std::size_t, std::vector<Draft>>& drafts, Data& data);

/// Sets Series::power_up. A run whose segments stand in several recordings, each but once, is one power-up: a file for
/// each tone. Its times are then those of the schedule. Else each run of each recording is one.
void set_power_ups(Data& data);

}  // namespace tumble::vibration
