#pragma once

#include <string>

#include "tumble/core/read_options.hpp"

namespace tumble {

/// Whether a column is the clock of a file, which is no channel, and has its unit from `options`: without a unit, or
/// with one that is not of time, the file cannot be read.
bool is_clock_column(const std::string& column, const std::string& file, ReadOptions options);

}  // namespace tumble
