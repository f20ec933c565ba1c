#pragma once

#include <string>
#include <vector>

#include "tumble/report/figure.hpp"
#include "tumble/report/figure/frame.hpp"
#include "tumble/report/figure/ticks.hpp"

/// Numbers as colours: the axis z of a figure.
namespace tumble::figure {

/// From the smallest number to the largest, as of CSS: dark blue over grey to yellow ("cividis" of matplotlib), which
/// people read alike who see red and green or do not, and which stays in order when printed without colours.
const std::vector<std::string>& colours();

/// Ends and ticks of the axis z, over the cells of the map and the coloured points.
Ticks scale_of(const Figure& figure, int most);

/// The colour of a number [u], which must be finite.
const std::string& colour_of(const Ticks& scale, double value);

/// The cells of a map, a path for each colour.
std::string cells(const Figure::Map& map, const Frame& frame, const Ticks& scale);

/// Points with their colours, with an edge, since they may have the colour of their cell.
std::string coloured_points(const Figure::Series& series, const Frame& frame, const Ticks& scale);

/// The scale beside the plot, and what it takes of the width [px].
double room_of_scale(const Ticks& scale);
std::string drawn_scale(const Figure::Axis& axis, const Frame& frame, const Ticks& scale);

}  // namespace tumble::figure
