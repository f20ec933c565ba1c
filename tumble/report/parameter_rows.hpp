#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"

namespace tumble {

/// A number for people in two parts, so that a column can be aligned at the decimal point: "-4" and ".12". The numbers
/// of one row have their power of ten in common.
struct SplitNumber {
  std::string before, after;  ///< `after` begins with the point, or is empty
};

/// A parameter as a line of a table, rounded by its standard uncertainty and in the unit that is shown.
struct ParameterRow {
  std::string name, readable, symbol, description, unit;
  SplitNumber value, sd;     ///< sd: also "unknown", "unbounded" or empty
  int exponent = 0;          ///< power of ten of value, sd, lower and upper
  std::string power;         ///< "× 10⁻⁵", empty for 0
  bool rounded = false;      ///< by its sd; else the value has six digits
  SplitNumber lower, upper;  ///< 95 % interval; empty: no interval
  std::string text;          ///< value and sd in one: "6.660 ± 0.011"
  std::string degrees_of_freedom;
};

ParameterRow parameter_row(const Estimate& estimate, std::size_t index);
std::vector<ParameterRow> parameter_rows(const Estimate& estimate);

/// "-4.12" in its two parts.
SplitNumber split_at_point(const std::string& number);

}  // namespace tumble
