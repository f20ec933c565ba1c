#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tumble/archive/history.hpp"

/// Requirements that the values of a parameter must meet together.
namespace tumble::statistics {

/// Throws Error::bad_input where there are no values. Given: model and unit that were asked for, or empty.
void require_values(const ParameterOverUnits& over, const std::string& model, const UnitName& unit);

/// Results whose units are compared: all of few, of many those in which each unit has the parameter first and last.
std::vector<std::int64_t> compared_results(const ParameterOverUnits& over);

/// The unit that people are shown. Throws Error::bad_input where units differ in dimension.
///
/// Given     shown  units of the compared results, each with the smallest number of a result that has it
Unit shown_unit(const ParameterOverUnits& over, const std::map<std::string, std::int64_t>& shown);

}  // namespace tumble::statistics
