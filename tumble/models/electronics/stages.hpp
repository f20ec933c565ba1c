#pragma once

#include <string>
#include <vector>

#include "tumble/models/electronics/response.hpp"

/// What instruments offer alike in [truth], and the stages that follow from it.
namespace tumble::electronics {

/// `natural_frequency` [Hz] and `damping_ratio` of a second-order loop. Without the first there is no loop.
std::vector<Option> loop_options();

/// Null where `natural_frequency` is not given.
Response loop(const Settings& truth, double step);

/// `range`, `range_negative`, `dead_zone` and `resolution` of the output, shown in `unit`.
std::vector<Option> limit_options(const std::string& unit);

/// Range, dead zone, resolution in this order; null where none is given. Throws Error::bad_input that lists all that
/// is out of bounds.
Response limits(const Settings& truth);

}  // namespace tumble::electronics
