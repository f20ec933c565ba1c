#pragma once

#include <string>
#include <vector>

namespace tumble {

/// A column of a terminal table, its cells already written.
struct TextColumn {
  enum class Align { left, right };
  std::string name;
  std::string unit;  ///< second line of the heading; empty: none
  std::vector<std::string> cells;
  Align align = Align::right;
};

/// The columns side by side, indented by two. What does not fit into `width` follows below, with the first column
/// repeated, and with as many after it as are needed to distinguish the rows where these take half the width at most.
/// Given     columns of equal length
/// Returned  lines, each with its line break.
std::string text_table(const std::vector<TextColumn>& columns, std::size_t width = 100);

/// `prefix` and behind it `text`, broken at blanks (and between Han characters) to lines of at most `width` (a longer
/// word stays whole), the later lines indented by the width of the prefix.
std::string wrapped(const std::string& prefix, const std::string& text, std::size_t width = 100);

/// `text` filled with blanks to `width` terminal columns.
std::string padded(const std::string& text, std::size_t width, TextColumn::Align align);

}  // namespace tumble
