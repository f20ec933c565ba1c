#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tumble/core/schedule.hpp"
#include "tumble/station/station_file.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::station_file {

/// In words, which limits of an axis a motion of a segment exceeds; empty: it keeps to all.
///
/// Given     stands_at  [rad, K] where the axis is before it; absent: not known
Problems beyond_limits(const Segment& segment, const StationAxis& axis, const Motion& motion,
                       std::optional<double> stands_at);

/// In words, which limits a temperature [K] exceeds that a command of the safe list gives to the controller.
Problems beyond_limits_of_safe(const StationAxis& axis, double temperature);

}  // namespace tumble::station_file
