#include "tumble/report/text_table.hpp"

#include <algorithm>
#include <set>

#include "tumble/report/utf8.hpp"

namespace tumble {
namespace {

constexpr std::size_t gap = 2;

/// The name of a column broken to lines no wider than its cells need, or than a word of it.
std::vector<std::string> heading_lines(const TextColumn& column, std::size_t cell_width) {
  const auto text = wrapped("", column.name, std::max<std::size_t>(cell_width, 14));
  std::vector<std::string> lines;
  for (std::size_t start = 0; start < text.size();) {
    const auto end = text.find('\n', start);
    lines.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  if (!column.unit.empty()) lines.push_back(column.unit);
  return lines;
}

struct Laid {
  const TextColumn* column;
  std::vector<std::string> heading;
  std::size_t width = 0;
};

Laid laid(const TextColumn& column) {
  std::size_t width = display_width(column.unit);
  for (const auto& cell : column.cells) width = std::max(width, display_width(cell));
  Laid result{&column, heading_lines(column, width), width};
  for (const auto& line : result.heading) result.width = std::max(result.width, display_width(line));
  return result;
}

void trim_end(std::string& line) { line.erase(line.find_last_not_of(' ') + 1); }

template <class CellOf>
std::string line_of(const std::vector<Laid>& columns, const CellOf& cell_of) {
  std::string line;
  for (const auto& column : columns) {
    line += std::string(gap, ' ') + padded(cell_of(column), column.width, column.column->align);
  }
  trim_end(line);
  return line + "\n";
}

std::string block(const std::vector<Laid>& columns) {
  std::size_t height = 0, width = 0;
  for (const auto& column : columns) {
    height = std::max(height, column.heading.size());
    width += column.width + gap;
  }
  std::string text;
  for (std::size_t line = 0; line < height; ++line) {
    text += line_of(columns, [&](const Laid& c) {
      const auto above = height - c.heading.size();
      return line < above ? std::string{} : c.heading[line - above];
    });
  }
  text += "  ";
  for (std::size_t i = gap; i < width; ++i) text += "─";
  text += "\n";
  for (std::size_t row = 0; row < columns.front().column->cells.size(); ++row) {
    text += line_of(columns, [row](const Laid& c) { return c.column->cells[row]; });
  }
  return text;
}

/// How many of the first columns distinguish each row from the others; 1 where all together do not, or are too wide.
std::size_t key_columns(const std::vector<Laid>& columns, std::size_t most_width) {
  const auto rows = columns.front().column->cells.size();
  std::vector<std::string> keys(rows);
  std::size_t used = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    used += gap + columns[i].width;
    if (i > 0 && used > most_width) return 1;
    for (std::size_t row = 0; row < rows; ++row) keys[row] += columns[i].column->cells[row] + '\n';
    if (std::set<std::string>(keys.begin(), keys.end()).size() == rows) return i + 1;
  }
  return 1;
}

}  // namespace

std::string padded(const std::string& text, std::size_t width, TextColumn::Align align) {
  const auto own = display_width(text);
  const std::string blanks(width > own ? width - own : 0, ' ');
  return align == TextColumn::Align::left ? text + blanks : blanks + text;
}

std::string text_table(const std::vector<TextColumn>& columns, std::size_t width) {
  if (columns.empty()) return {};
  std::vector<Laid> all;
  for (const auto& column : columns) all.push_back(laid(column));
  const auto keys = key_columns(all, width / 2);
  const auto width_of = [](const std::vector<Laid>& some) {
    std::size_t sum = 0;
    for (const auto& column : some) sum += gap + column.width;
    return sum;
  };
  std::string text;
  std::vector<Laid> side_by_side(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(keys));
  for (std::size_t i = keys; i < all.size(); ++i) {
    if (width_of(side_by_side) + gap + all[i].width > width && side_by_side.size() > keys) {
      text += block(side_by_side) + "\n";
      side_by_side.resize(keys);
    }
    side_by_side.push_back(all[i]);
  }
  return text + block(side_by_side);
}

std::string wrapped(const std::string& prefix, const std::string& text, std::size_t width) {
  const std::string indent(display_width(prefix), ' ');
  std::string result, line = prefix;
  bool empty = true;
  for (std::size_t start = 0; start < text.size();) {
    const auto end = std::min(text.find(' ', start), text.size());
    const auto parts = breakable_parts(std::string_view(text).substr(start, end - start));
    start = end + 1;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::string blank = i == 0 ? " " : "";
      if (!empty && display_width(line) + blank.size() + display_width(parts[i]) > width) {
        result += line + "\n";
        line = indent;
        empty = true;
      }
      line += (empty ? "" : blank) + parts[i];
      empty = false;
    }
  }
  return result + line + "\n";
}

}  // namespace tumble
