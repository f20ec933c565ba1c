#include "tumble/wire/codec/line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "tumble/wire/declaration/declared.hpp"
#include "tumble/wire/declaration/format.hpp"

namespace tumble::declaration {

namespace {

constexpr int most_columns = 1000;
constexpr int longest_line = 8192;  ///< [byte]
constexpr int most_digits = 30;     ///< [character] of a number

/// "+09.4": sign, zeros in front, width, decimals.
std::optional<FrameFormat> parse_format(std::string_view text) {
  auto format = take_format(text, most_digits);
  if (!format || !text.empty()) return std::nullopt;
  format->given = true;
  return format;
}

/// The index of that cell; it is added where it is new.
int add_cell(tables::Section& section, const FrameCell& cell, FrameLayout& layout) {
  auto& cells = layout.text->cells;
  const auto same = [&](const FrameCell& other) {
    return other.column == cell.column && other.at == cell.at && other.width == cell.width;
  };
  const auto found = std::ranges::find_if(cells, same);
  const auto index = static_cast<int>(found - cells.begin());
  if (found != cells.end()) {
    if (cell.format.given) found->format = cell.format;
    return index;
  }
  if (cells.size() == codec::most_items) {
    section.problem(say("more than {} cells in one line", codec::most_items));
    return 0;
  }
  cells.push_back(cell);
  layout.items.push_back({static_cast<std::uint64_t>(index), 0});
  return index;
}

bool is_delimiter(const std::string& text) {
  return text.size() == 1 && codec::is_of_line(static_cast<unsigned char>(text[0])) &&
         std::string_view("+-._").find(text[0]) == std::string_view::npos && !(text[0] >= '0' && text[0] <= '9') &&
         !((text[0] | 0x20) >= 'a' && (text[0] | 0x20) <= 'z');
}

}  // namespace

int cell_of(tables::Section& section, FrameLayout& layout, int offset) {
  FrameCell cell;
  const auto column = section.integer("column"), width = section.integer("width"), at = section.integer("at");
  const auto format = section.text("format");
  if (format) {
    const auto parsed = parse_format(*format);
    if (!parsed) section.problem_at("format", "sign, width and decimals are expected, \"+09.4\" or \".6\"");
    cell.format = parsed.value_or(FrameFormat{});
  }
  if (column && (width || at)) section.problem("column, or at and width: a cell has one of these");
  if (column) {
    cell.column = *column + offset;
    if (cell.column >= most_columns)
      section.problem_at("column", say("a column below {} is expected", most_columns)), cell.column = 0;
  } else if (width && at) {
    cell.at = *at + offset;
    cell.width = *width;
    if (cell.width < 1 || cell.width > 64 || cell.at > longest_line)
      section.problem_at("width", "1 to 64 characters are expected"), cell.at = 0, cell.width = 1;
  } else {
    section.missing("column", "0");
    cell.column = 0;
  }
  return add_cell(section, cell, layout);
}

bool read_line(tables::Section& section, FrameLayout& layout) {
  const auto* node = section.find("text");
  if (node && !node->is_boolean()) section.problem_at("text", "true is expected where the frame is a line of text");
  if (!layout.text && !(node && node->value_or(false))) return false;
  if (!layout.text) layout.text.emplace(), layout.end = "\r\n";
  if (const auto head = section.text("head")) layout.sync = *head;
  layout.sync_mask.assign(layout.sync.size(), '\xff');
  if (layout.sync.size() > 64 || !std::ranges::all_of(layout.sync, codec::is_of_line))
    section.problem_at("head", "up to 64 printed characters are expected");
  if (const auto end = section.text("end")) layout.end = *end;
  if (layout.end != "\r\n" && layout.end != "\n" && layout.end != "\r") {
    section.problem_at("end", R"("\r\n", "\n" or "\r" is expected)");
    layout.end = "\n";
  }
  if (const auto delimiter = section.text("delimiter")) {
    if (is_delimiter(*delimiter))
      layout.text->delimiter = delimiter->front();
    else
      section.problem_at("delimiter", R"(one character is expected: "," or ";" or "\t" or " " for spaces and tabs)");
  }
  layout.longest = section.integer("longest").value_or(layout.longest);
  if (layout.longest < 1 || layout.longest > longest_line)
    section.problem_at("longest", say("at most {} bytes", longest_line)), layout.longest = longest_line;
  return true;
}

void close_line(tables::Section& section, FrameLayout& layout) {
  FrameText& text = *layout.text;
  int used = 0;
  bool fixed = false;
  text.length = 0;
  for (const FrameCell& cell : text.cells) {
    used = std::max(used, cell.column + 1);
    text.length = std::max(text.length, cell.at + cell.width);
    fixed = fixed || cell.width > 0;
    if (cell.width > 0 && cell.at < static_cast<int>(layout.sync.size()))
      section.problem("a cell of fixed width lies in the head");
  }
  if (fixed && used > 0) section.problem("a line has columns, or cells of fixed width, and not both");
  text.items.assign(static_cast<std::size_t>(used), -1);
  for (std::size_t i = 0; i < text.cells.size(); ++i)
    if (text.cells[i].column >= 0) text.items[static_cast<std::size_t>(text.cells[i].column)] = static_cast<int>(i);
  const auto columns = section.integers("columns");
  text.least = columns.empty() ? used : columns.front();
  text.most = columns.empty() ? used : columns.back();
  if (columns.size() > 2 || text.least > text.most || text.most > most_columns || text.most < used)
    section.problem_at("columns", say("how many columns a line has is expected, or the least and the most: {} or more, "
                                      "up to {}",
                                      used, most_columns));
  if (layout.sync.empty() && layout.checks.empty() && text.cells.empty())
    section.problem("a line is recognised by its head, its checksum or its columns: it has none of these");
}

}  // namespace tumble::declaration
