#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/reduce/vibration/windows.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::vibration {

/// One unit in one recording, with the values of its channel unchanged.
struct Draft {
  const Channel* channel = nullptr;
  Windows windows;
  std::vector<std::size_t> series;  ///< in Data::series
  std::vector<std::size_t> first;   ///< sample with which each begins
};

/// Corrects the counts of segments that vibrate where the register overflowed. At rest it does not overflow: the mean
/// at rest shows what the other counts lie about. Where the correction is ambiguous, a problem.
void unwrap_counts(const Settings& settings, const Draft& draft, Data& data, Problems& problems);

/// Counts at rest that grow by a pulse and more from window to window are a running total: a problem.
void refuse_totals(const Draft& draft, const Data& data, Problems& problems);

/// Removes segments that shake in which a unit gives one value throughout, or for a long time in succession: dead, or
/// not connected. Segments at rest in which it gives the value at which it died are removed with them.
void drop_dead(Data& data);

/// Cuts segments of random vibration to the time in which they vibrate, where the shaker begins late or ends early, or the
/// marks are late: a finding.
void cut_to_vibrations(Data& data);

/// A finding for each segment of random vibration whose size changes along the segment.
void check_ramps(Data& data);

/// Removes segments of random vibration in which the unit is as quiet as at rest although the plan wants far more: the shaker was
/// off, or the labels are those of other segments. Values are in m/s^2.
void drop_still(Data& data);

/// sd [m/s^2] of the windows of a random vibration, as the plan wants it.
double planned_sd(const Series& series);

/// Sets Data::departures: the rests of each unit whose scale factor is given against the plan's rig, beyond four times
/// what scale_factor_sd, bias_sd and an axis that is 2 deg off allow. A unit whose scale factor is from its rests shows their sign
/// alone: it is turned over where it counts down and another unit of the fixture counts up.
void compare_rests(const Settings& settings, Data& data);

/// Values that no accelerometer shows, as by a unit or a scale factor that is wrong by many powers of ten: a problem
/// for each unit and for the reference.
void refuse_sizes(const Data& data, Problems& problems);

/// Removes segments planned at rest in which the unit moves, as while the shaker runs up: the spread is 20 times that
/// of the unit's quietest, and more than three pulses or a thousandth of the mean. Values are still those of the
/// channel.
void drop_moving(const std::map<std::size_t, std::vector<Draft>>& drafts, Data& data);

/// Sets Series::power_up. A run whose segments are in several recordings, each once only, is one power-up: a file for
/// each tone. Its times are then those of the schedule. Otherwise each run of each recording is one.
void set_power_ups(Data& data);

}  // namespace tumble::vibration
