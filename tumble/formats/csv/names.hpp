#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/read_options.hpp"

namespace tumble::csv {

/// Where the unit of a column stands.
enum class UnitFrom { nowhere, brackets, row, options, words, convention };

/// A column as its header names it.
struct ColumnName {
  std::string cell;  ///< of the header
  std::string name;
  std::string unit;  ///< as written; empty: not said
  UnitFrom from = UnitFrom::nowhere;
};

/// Names and units of the columns. A unit stands in brackets behind the name, in the row of units, in the options, in
/// other words behind the name ("Zeit (s)", "T / degC", "Zeit in s"), or follows from a name that ROS defines. An index
/// in brackets (covariance[4]) is part of the name.
/// Given  cells  of the header; `units`: of the row of units, or empty; only_brackets: names given by the user
std::vector<ColumnName> column_names(const std::vector<std::string>& cells, const std::vector<std::string>& units,
                                     const ReadOptions& options, bool only_brackets);

/// The unit, also as "rad s^-1" or "m.s-2". Throws Error::bad_input as Unit::parse.
Unit parse_written_unit(const std::string& text);

/// Why a column of that name is no signal: "covariance", "counter"; empty: it may be one.
std::string_view no_signal(std::string_view name);

/// The unit that is likely for a column of that name, for a proposal; "1" where nothing is likely.
/// Given  greatest  magnitude of its values [as written]
std::string likely_unit(std::string_view name, double greatest);

/// Whether the name is that of the segment a sample belongs to: part, label, position.
bool names_segments(std::string_view name);

}  // namespace tumble::csv
