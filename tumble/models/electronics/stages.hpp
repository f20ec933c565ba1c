#pragma once

#include <string>
#include <vector>

#include "tumble/models/electronics/response.hpp"

/// Options that instruments have in common in [truth], and the stages that follow from them.
namespace tumble::electronics {

/// `natural_frequency` [Hz] and `damping_ratio` of a second-order loop. Without the first there is no loop.
std::vector<Option> loop_options();

/// A loop of second order where `natural_frequency` is given, of first order where an option `time_constant` is; null
/// where neither is given. Given: step of the simulation [s]. Throws Error::bad_input for options that exclude or need
/// each other, those of limits() too.
Response loop(const Settings& truth, double step);

/// The second-order loop of a pick-off of this inertia [kg m^2], damping [N m s/rad] and stiffness [N m/rad]; null
/// where one of them is not known, which is 0.
Response balanced(double inertia, double damping, double stiffness, double step);

/// `range`, `range_negative`, `dead_zone` and `resolution` of the output, shown in `unit`.
std::vector<Option> limit_options(const std::string& unit);

/// Range, dead zone, resolution in this order; null where none is given. Throws Error::bad_input as loop().
Response limits(const Settings& truth);

}  // namespace tumble::electronics
