#include "tumble/report/text_table.hpp"

#include <algorithm>

#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

constexpr std::size_t gap = 2;

std::size_t width_of(const TextColumn& column) {
  std::size_t width = std::max(display_width(column.name), display_width(column.unit));
  for (const auto& cell : column.cells) width = std::max(width, display_width(cell));
  return width;
}

void trim_end(std::string& line) { line.erase(line.find_last_not_of(' ') + 1); }

template <class CellOf>
std::string line_of(const std::vector<const TextColumn*>& columns, const CellOf& cell_of) {
  std::string line;
  for (const auto* column : columns) {
    line += std::string(gap, ' ') + padded(cell_of(*column), width_of(*column), column->align);
  }
  trim_end(line);
  return line + "\n";
}

std::string block(const std::vector<const TextColumn*>& columns) {
  std::string text = line_of(columns, [](const TextColumn& c) { return c.name; });
  const bool units = std::any_of(columns.begin(), columns.end(), [](const auto* c) { return !c->unit.empty(); });
  if (units) text += line_of(columns, [](const TextColumn& c) { return c.unit; });
  std::size_t width = 0;
  for (const auto* column : columns) width += width_of(*column) + gap;
  text += "  ";
  for (std::size_t i = gap; i < width; ++i) text += "─";
  text += "\n";
  for (std::size_t row = 0; row < columns.front()->cells.size(); ++row) {
    text += line_of(columns, [row](const TextColumn& c) { return c.cells[row]; });
  }
  return text;
}

}  // namespace

std::string padded(const std::string& text, std::size_t width, TextColumn::Align align) {
  const auto own = display_width(text);
  const std::string blanks(width > own ? width - own : 0, ' ');
  return align == TextColumn::Align::left ? text + blanks : blanks + text;
}

std::string text_table(const std::vector<TextColumn>& columns, std::size_t width) {
  if (columns.empty()) return {};
  std::string text;
  std::vector<const TextColumn*> side_by_side{&columns.front()};
  std::size_t used = gap + width_of(columns.front());
  for (std::size_t i = 1; i < columns.size(); ++i) {
    const auto own = gap + width_of(columns[i]);
    if (used + own > width && side_by_side.size() > 1) {
      text += block(side_by_side) + "\n";
      side_by_side.resize(1);
      used = gap + width_of(columns.front());
    }
    side_by_side.push_back(&columns[i]);
    used += own;
  }
  return text + block(side_by_side);
}

std::string wrapped(const std::string& prefix, const std::string& text, std::size_t width) {
  const std::string indent(display_width(prefix), ' ');
  std::string result, line = prefix;
  bool empty = true;
  for (std::size_t start = 0; start < text.size();) {
    const auto end = std::min(text.find(' ', start), text.size());
    const auto word = text.substr(start, end - start);
    start = end + 1;
    if (word.empty()) continue;
    if (!empty && display_width(line) + 1 + display_width(word) > width) {
      result += line + "\n";
      line = indent;
      empty = true;
    }
    line += (empty ? "" : " ") + word;
    empty = false;
  }
  return result + line + "\n";
}

}  // namespace tumble
