#pragma once

#include <vector>

#include "tumble/report/figure.hpp"

namespace tumble::figure {

/// Maps and coloured points of the tables of an estimate:
///
///   thermal_map     a row for each cell of a grid: its middle in the first two columns, then what there is
///   thermal_points  a row for each point: its place in the first two columns, then what was found there
///
/// Each further column of numbers is a figure over the first two columns. What both tables have under one name stands
/// in one figure, so that points beside the colour of their cell show what the map does not follow. A grid of one
/// column or of one row is not drawn.
std::vector<Figure> maps_of(const Estimate& estimate);

/// Whether a table is of cells or points by its name.
bool is_of_map(const Table& table);

}  // namespace tumble::figure
