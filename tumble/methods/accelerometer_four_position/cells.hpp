#pragma once

#include "tumble/methods/accelerometer_four_position/positions.hpp"

namespace tumble::accelerometer_four_position {

/// Drops segments that hold angles too while the temperature is reached: the mount, or where the head stands. Such a
/// one commands the temperature, and a later one does not that holds the same position at this temperature.
///
/// Given     same   [K] within which two temperatures are one
void drop_soaks(double same, Bench& bench);

/// The cells of a bench by its positions, in groups of one temperature; findings on cells that lack positions, and on
/// sets that were turned over, which are dropped. Throws Error::bad_data without a cell.
void add_cells(const Settings& settings, Bench& bench);

}  // namespace tumble::accelerometer_four_position
