#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/read_options.hpp"

namespace tumble::csv {

/// A line of the table: not blank, not a comment.
struct TextLine {
  std::string_view text;
  std::size_t number = 0;   ///< in the file, from 1
  std::string_view before;  ///< the comment directly before it
};

/// The lines at the beginning of a text, `most` at most.
/// Given  first_number  in the file, of the first line
std::vector<TextLine> first_lines(std::string_view text, std::size_t first_number, std::size_t most);

/// Where a table begins, and what separates its cells.
struct Shape {
  char separator = ',';
  std::size_t columns = 0;            ///< of the rows, without cells at the end that are always empty
  std::optional<std::size_t> header;  ///< index of the line with the names
  std::optional<std::size_t> units;   ///< index of the line with the units
  std::size_t rows = 0;               ///< index of the first line with samples
  bool header_in_comment = false;     ///< the comment before the first row has the names
};

/// Finds the header among the lines before the first row. Without a preamble it is the first line, unless that holds
/// numbers. Throws nothing: a table without a header has none.
Shape shape_of(const std::vector<TextLine>& lines, const ReadOptions& options);

/// Tabs, semicolons and commas outside quotes and units separate, in this order of preference; else blanks.
char separator_of(std::string_view header);

/// Whether the cells are units, "-" and blanks, half of them units at least.
bool units_row(const std::vector<std::string>& cells);

/// A cell of a row of units without the brackets around it.
std::string bare_unit(const std::string& cell);

}  // namespace tumble::csv
