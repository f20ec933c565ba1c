#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/format.hpp"

namespace tumble::csv {

struct Column {
  std::string name;
  Unit unit;
  bool time = false;
  bool wanted = true;
  bool label = false;  ///< text: the segment that the sample belongs to
};

/// What the lines before the first sample say.
struct Layout {
  char separator = ',';  ///< ' ': any run of blanks and tabs
  char mark = '.';       ///< the decimal mark
  std::vector<Column> columns;
  std::optional<Timeline> clock;  ///< stated in a comment by our own writer
  Recording annotations;          ///< instrument, marks, meta, findings
  std::map<std::string, QuantityKind> kinds;
  std::size_t lines = 0;  ///< read, the header included
};

/// Reads comments and the header from the first piece of a file and moves `text` behind them. Where numbers stand in
/// place of the header, options.columns are the header. Throws Error::bad_file with every column that has no unit or
/// one that cannot be read.
Layout read_layout(const std::string& path, std::string_view& text, const ReadOptions& options);

/// Cells of one line: quotes removed and blanks around them, quoted separators kept. Blanks as separator collapse.
std::vector<std::string> cells_of(std::string_view line, char separator);

std::string_view trimmed(std::string_view text);

}  // namespace tumble::csv
