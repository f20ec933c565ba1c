#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/clock.hpp"
#include "tumble/formats/csv/encoding.hpp"
#include "tumble/formats/format.hpp"

namespace tumble::csv {

struct Column {
  std::string name;
  Unit unit;
  bool time = false;
  bool wanted = true;
  bool label = false;  ///< text: the segment that the sample belongs to
  bool signal = true;  ///< holds numbers, as far as its first cells show
};

/// Contents of the lines before the first sample.
struct Layout {
  char separator = ',';  ///< ' ': any run of blanks and tabs
  char mark = '.';       ///< the decimal mark
  std::vector<Column> columns;
  std::optional<Timeline> clock;  ///< stated in a comment by our own writer
  Clock stamp;                    ///< where stamped(): dates, Unix time, or seconds and nanoseconds
  Recording annotations;          ///< instrument, marks, meta, findings, what was recognised
  std::map<std::string, QuantityKind> kinds;
  std::size_t lines = 0;  ///< read, the header included
};

/// Reads preamble, comments, header and units from the first piece of a file, and moves `text` behind them. Where there
/// is no header, options.columns are the header. What was recognised is noted. Throws Error::bad_file with every column
/// that has no unit or one that cannot be read, and with options that would read the file.
Layout read_layout(const std::string& path, std::string_view& text, const ReadOptions& options,
                   const Encoding& encoding);

}  // namespace tumble::csv
