#pragma once

#include <map>
#include <string>

#include "tumble/archive/statistics.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble::fleet {

/// Lower and upper limit as they were written; empty: none.
struct WrittenLimits {
  std::string lower, upper;
};
using LimitsByName = std::map<std::string, WrittenLimits>;

/// Limits by the settings "NAME.min" and "NAME.max". Throws Error::bad_input for other keys.
LimitsByName limits_by_name(const Sets& sets);

/// Limits [SI] of a parameter that people are shown in this unit; infinite: no limit. Throws Error::bad_input for
/// another dimension, and a lower limit that is not below the upper one.
ParameterLimits limits_in(const LimitsByName& limits, const std::string& name, const Unit& unit);

}  // namespace tumble::fleet
