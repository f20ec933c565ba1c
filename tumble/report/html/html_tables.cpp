#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/report/html/html.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/utf8.hpp"

namespace tumble::html {
namespace {

// Characters of 9 pt beside each other on A4: upright, and on its side.
constexpr std::size_t on_upright = 94, on_its_side = 138, between_columns = 1, widest_text = 28;

struct TableColumn {
  std::vector<std::string> cells;
  bool all_text = true;
  std::size_t width = 0;   ///< [characters]
  std::size_t narrow = 0;  ///< where its words stand on lines of their own
};

std::size_t longest_word(std::string_view text) {
  std::size_t longest = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find(' '), text.size());
    for (const auto& part : breakable_parts(text.substr(0, end))) longest = std::max(longest, display_width(part));
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  return longest;
}

/// Figure space and punctuation space are as wide as a digit and as the point.
TableColumn table_column(const Table& table, std::size_t index) {
  std::vector<double> numbers;
  for (const auto& row : table.rows) {
    const auto* value = std::get_if<double>(&row[index]);
    numbers.push_back(value ? table.columns[index].unit.from_si(*value) : NAN);
  }
  const auto& heading = table.columns[index];
  const auto least = std::max(longest_word(readable_name(heading.name)), display_width(heading.unit.text()));
  TableColumn column{lined_up(numbers, "\u2007", "\u2008"), true, least, least};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto* text = std::get_if<std::string>(&table.rows[i][index]);
    column.width =
        std::max(column.width, text ? std::min(display_width(*text), widest_text) : display_width(column.cells[i]));
    column.narrow = std::max(column.narrow, text ? longest_word(*text) : display_width(column.cells[i]));
    column.cells[i] = text ? escaped(*text) : number(column.cells[i]);
    if (!text) column.all_text = false;
  }
  return column;
}

/// The columns from `first` to `end`, in front of them column 0 where `first` is another.
std::string block_html(const Table& table, const std::vector<TableColumn>& columns, std::size_t first, std::size_t end,
                       const std::string& caption, const char* page) {
  std::vector<std::size_t> shown;
  if (first > 0) shown.push_back(0);
  for (std::size_t i = first; i < end; ++i) shown.push_back(i);
  std::string text =
      fmt::format("<div class=\"scroll{}\" tabindex=\"0\"><table>\n<caption>{}</caption>\n<thead><tr>", page, caption);
  for (const auto i : shown)
    text += fmt::format("<th scope=\"col\"{}>{}<span class=\"unit\">{}</span></th>",
                        columns[i].all_text ? "" : " class=\"n\"", escaped(readable_name(table.columns[i].name)),
                        unit(table.columns[i].unit));
  text += "</tr></thead>\n<tbody>\n";
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    text += "<tr>";
    for (const auto i : shown)
      text += (columns[i].all_text ? "<td>" : "<td class=\"n\">") + columns[i].cells[row] + "</td>";
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

/// Where blocks of columns begin that fit on a sheet that lies on its side.
std::vector<std::size_t> blocks_of(const std::vector<TableColumn>& columns) {
  std::vector<std::size_t> begins{0};
  std::size_t used = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto needed = columns[i].width + between_columns;
    if (used > 0 && used + needed > on_its_side) {
      begins.push_back(i);
      used = columns[0].width + between_columns;
    }
    used += needed;
  }
  return begins;
}

/// In Chinese with its key, by which findings and programs call it.
std::string table_name(const Table& table, const std::string& method, const Words& words) {
  return words.language == Language::english ? escaped(readable_name(table.name))
                                             : name_html(table.name, words, method);
}

std::string table_html(const Table& table, std::size_t count, const std::string& method, const Words& words) {
  std::vector<TableColumn> columns;
  std::size_t width = 0;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    columns.push_back(table_column(table, i));
    width += columns.back().width + between_columns;
  }
  const auto caption =
      words.with("table_caption", words.with("table", std::to_string(count)), table_name(table, method, words),
                 table.caption.empty() ? "" : words("colon") + escaped(table.caption));
  if (width > on_its_side)
    for (auto& column : columns) column.width = std::min(column.width, column.narrow);
  auto begins = blocks_of(columns);
  begins.push_back(columns.size());
  std::string text;
  for (std::size_t i = 0; i + 1 < begins.size(); ++i)
    text += block_html(table, columns, begins[i], begins[i + 1], i == 0 ? caption : caption + " " + words("continued"),
                       width > on_upright ? " sideways" : "");
  return text;
}

}  // namespace

std::string tables(const Estimate& estimate, const Words& words) {
  std::string text, for_programs;
  std::size_t count = 0;
  for (const auto& table : estimate.tables) {
    if (table.for_programs)
      for_programs += (for_programs.empty() ? "" : words("plot_next")) + escaped(table.name);
    else
      text += table_html(table, ++count, estimate.method, words);
  }
  if (!for_programs.empty()) text += "<p class=\"note\">" + words.with("tables_for_programs", for_programs) + "</p>\n";
  return text.empty() ? "" : "<section id=\"tables\">\n<h2>" + words("tables") + "</h2>\n" + text + "</section>\n";
}

}  // namespace tumble::html
