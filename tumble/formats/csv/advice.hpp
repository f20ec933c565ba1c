#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tumble/formats/csv/layout.hpp"
#include "tumble/formats/csv/shape.hpp"

namespace tumble::csv {

/// `tumble inspect FILE --set ...` with what the options say and with further key=value, quoted for a shell.
std::string command_line(const std::string& path, const ReadOptions& options, const std::vector<std::string>& further);

/// How the beginning of a table was understood.
struct Understood {
  const std::string& path;
  const ReadOptions& options;
  const Encoding& encoding;
  const std::vector<TextLine>& lines;
  const Shape& shape;
  const std::vector<ColumnName>& names;
  const std::vector<ColumnSample>& samples;
  const std::vector<std::pair<std::size_t, std::string>>& skipped;  ///< columns, and why
};

/// Adds to layout.annotations what was recognised beyond a plain table (UTF-8, header name[unit], time[unit]): a
/// finding for each, and the list that inspect shows.
void say_what_was_recognised(Layout& layout, const Understood& table);

/// The unit with which the stamps of an instrument of 1 Hz to 10 kHz would advance so; "day" for dates of a worksheet.
std::string likely_clock_unit(const ColumnSample& sample);

}  // namespace tumble::csv
