#include "tumble/formats/csv/shape.hpp"

#include <algorithm>
#include <map>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/stamp.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

constexpr std::size_t body_lines = 100;  // at most, to show what rows look like

bool is_value(const std::string& cell) { return numeric(cell) || stamp_kind(cell) != StampKind::none; }

/// Lines as cells, for one separator.
struct Table {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> filled;  ///< cells of each, without empty ones at the end

  Table(const std::vector<TextLine>& lines, char separator) {
    for (const TextLine& line : lines) {
      rows.push_back(cells_of(line.text, separator));
      std::size_t count = rows.back().size();
      while (count > 1 && rows.back()[count - 1].empty()) --count;
      filled.push_back(count);
    }
  }
  std::size_t body() const { return rows.size() - std::min(body_lines, (rows.size() + 1) / 2); }
};

/// What most rows have in common.
struct Body {
  std::size_t cells = 0;      ///< of a row
  std::size_t columns = 0;    ///< cells, without those at the end that are always empty
  double share = 0.0;         ///< of the lines with as many cells
  std::vector<bool> numbers;  ///< columns that hold numbers or times
};

Body body_of(const Table& table) {
  std::map<std::size_t, std::size_t> votes;
  for (std::size_t i = table.body(); i < table.rows.size(); ++i) ++votes[table.rows[i].size()];
  Body body;
  std::size_t most = 0;
  for (const auto& [cells, count] : votes)
    if (count > most || (count == most && body.cells != table.filled.front())) {
      most = count;
      body.cells = cells;
    }
  body.share = static_cast<double>(most) / static_cast<double>(table.rows.size() - table.body());
  std::vector<std::size_t> numbers(body.cells), filled(body.cells);
  for (std::size_t i = table.body(); i < table.rows.size(); ++i) {
    if (table.rows[i].size() != body.cells) continue;
    for (std::size_t c = 0; c < body.cells; ++c) {
      const std::string& cell = table.rows[i][c];
      filled[c] += !cell.empty();
      numbers[c] += !cell.empty() && is_value(cell);
      if (!cell.empty()) body.columns = std::max(body.columns, c + 1);
    }
  }
  for (std::size_t c = 0; c < body.cells; ++c) body.numbers.push_back(filled[c] > 0 && 2 * numbers[c] >= filled[c]);
  return body;
}

bool of_the_table(const Table& table, std::size_t line, const Body& body) {
  return table.rows[line].size() == body.cells ||
         (table.filled[line] >= body.columns && table.filled[line] <= body.cells);
}

/// Whether the line holds samples: where rows have numbers it has more numbers than words.
bool is_row(const Table& table, std::size_t line, const Body& body) {
  if (!of_the_table(table, line, body)) return false;
  const auto& cells = table.rows[line];
  int votes = 0;
  bool first = true, first_is_number = false;
  for (std::size_t c = 0; c < std::min(cells.size(), body.numbers.size()); ++c) {
    if (!body.numbers[c] || cells[c].empty()) continue;
    const bool number = is_value(cells[c]);
    if (first) first_is_number = number;
    first = false;
    votes += number ? 1 : -1;
  }
  return votes > 0 || (votes == 0 && first_is_number);
}

/// Rows of at least two cells, mostly numbers.
bool good(const Body& body) {
  const auto numbers = static_cast<std::size_t>(std::ranges::count(body.numbers, true));
  return body.columns >= 2 && body.share >= 0.75 && 2 * numbers > body.columns;
}

char best_separator(const std::vector<TextLine>& lines) {
  const char first = separator_of(lines.front().text);
  if (first == ' ')  // of a first line of words, which dates and names below may match by accident
    for (const char candidate : {'\t', ';', ','}) {
      const Body body = body_of(Table(lines, candidate));
      const auto numbers = static_cast<std::size_t>(std::ranges::count(body.numbers, true));
      if (good(body) && (candidate != ',' || numbers == body.columns)) return candidate;  // "0,1 0,2" has "1 0"
    }
  const Table table(lines, first);
  const Body body = body_of(table);
  if (body.columns >= 2 && of_the_table(table, 0, body)) return first;
  for (const char candidate : {'\t', ';', ',', ' '})
    if (candidate != first && good(body_of(Table(lines, candidate)))) return candidate;
  return first;
}

bool says_units(const std::vector<std::string>& cells) {
  return std::ranges::any_of(cells, [](const std::string& cell) {
    const auto unit = name_and_unit(cell).unit;
    return !unit.empty() && unit.find_first_not_of("0123456789") != std::string::npos;
  });
}

/// The header among the lines of the table before the first row: that with units in its cells, that before the units,
/// or the last.
void find_header(Shape& shape, const Table& table, const Body& body) {
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < shape.rows; ++i)
    if (of_the_table(table, i, body)) candidates.push_back(i);
  if (candidates.empty()) {
    if (shape.rows == 1 && table.filled[0] > 1) shape.header = 0;
    return;
  }
  for (std::size_t k = 0; k < candidates.size() && !shape.header; ++k)
    if (says_units(table.rows[candidates[k]])) shape.header = candidates[k];
  for (std::size_t k = 1; k < candidates.size() && !shape.header; ++k)
    if (units_row(table.rows[candidates[k]])) {
      shape.header = candidates[k - 1];
      shape.units = candidates[k];
    }
  // Behind the units comes the first sample, even of words ("OL"), where its first column says a number or a time.
  for (const std::size_t i : candidates)
    if (const std::string& cell = table.rows[i].front();
        shape.units && i > *shape.units && body.numbers.front() && is_value(cell) && !reads_like_missing(cell)) {
      shape.rows = i;
      break;
    }
  if (!shape.header) shape.header = candidates.back();
  if (!shape.units && says_units(table.rows[*shape.header])) shape.rows = *shape.header + 1;
}

/// "# time[s],gyro[deg/h]" directly before the first row.
bool names_in_comment(const TextLine& line, const Shape& shape) {
  if (line.before.empty()) return false;
  const auto cells = cells_of(line.before, shape.separator);
  return cells.size() == shape.columns && shape.columns > 1 &&
         std::ranges::none_of(cells, [](const std::string& cell) { return cell.empty() || is_value(cell); });
}

/// The columns are named: their number says which lines belong to the table, and whether the first is a header.
Shape shape_of_columns(const std::vector<TextLine>& lines, const ReadOptions& options) {
  Shape shape;
  shape.columns = options.columns.size();
  std::size_t begin = lines.size();
  std::vector<char> separators{separator_of(lines.front().text)};
  for (const char candidate : {'\t', ';', ',', ' '}) separators.push_back(candidate);
  for (const char separator : separators) {
    const Table table(lines, separator);
    for (std::size_t i = 0; i < lines.size() && begin == lines.size(); ++i)
      if (table.filled[i] <= shape.columns && table.rows[i].size() >= shape.columns) begin = i;
    shape.separator = separator;
    if (begin < lines.size()) break;
  }
  if (begin == lines.size()) {
    shape.separator = separators.front();
    return shape;
  }
  const auto row = [&](std::size_t index) {
    const auto cells = cells_of(lines[index].text, shape.separator);
    for (std::size_t i = 0; i < std::min(cells.size(), shape.columns); ++i) {
      const auto& column = options.columns[i];
      const bool value = column != not_read && name_and_unit(column).name != options.segment_column;
      if (value && !cells[i].empty() && cells[i] != options.missing && !is_number(cells[i]) && !is_value(cells[i]))
        return false;
    }
    return true;
  };
  shape.rows = begin;
  if (row(begin)) return shape;
  shape.header = shape.rows++;
  if (shape.rows < lines.size() && !row(shape.rows) && units_row(cells_of(lines[shape.rows].text, shape.separator)))
    shape.units = shape.rows++;
  return shape;
}

}  // namespace

std::vector<TextLine> first_lines(std::string_view text, std::size_t first_number, std::size_t most) {
  std::vector<TextLine> lines;
  std::string_view comment;
  for (std::size_t number = first_number; !text.empty() && lines.size() < most; ++number) {
    const auto end = text.find('\n');
    const auto line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const auto content = trimmed(line);
    if (content.empty()) continue;
    if (content.front() == '#') {
      comment = trimmed(content.substr(1));
      continue;
    }
    lines.push_back({line, number, comment});
    comment = {};
  }
  return lines;
}

char separator_of(std::string_view header) {
  for (const char candidate : {'\t', ';', ','}) {
    bool quoted = false;
    int brackets = 0;
    for (const char c : header) {
      if (c == '"') quoted = !quoted;
      if (!quoted) brackets += (c == '[') - (c == ']');
      if (c == candidate && !quoted && brackets <= 0) return candidate;
    }
  }
  // Blanks separate only where each word is a column: "gyro x [deg/h]" alone is one.
  const auto words = cells_of(header, ' ');
  const bool columns = words.size() > 1 && std::none_of(words.begin(), words.end(), [](const std::string& word) {
                         return word.empty() || word.front() == '[';
                       });
  return columns ? ' ' : ',';
}

std::string bare_unit(const std::string& cell) {
  const bool square = cell.starts_with('[') && cell.ends_with(']');
  const bool round = cell.starts_with('(') && cell.ends_with(')') && cell.find(')') == cell.size() - 1;
  return std::string(trimmed(square || round ? std::string_view(cell).substr(1, cell.size() - 2) : cell));
}

bool units_row(const std::vector<std::string>& cells) {
  std::size_t units = 0, words = 0;
  for (const std::string& cell : cells) {
    const auto unit = bare_unit(cell);
    if (unit.empty() || unit == not_read) continue;
    ++words;
    try {
      Unit::parse(unit);
      ++units;
    } catch (const Error&) {
    }
  }
  return units > 0 && 2 * units >= words;
}

Shape shape_of(const std::vector<TextLine>& lines, const ReadOptions& options) {
  if (!options.columns.empty()) return shape_of_columns(lines, options);
  Shape shape;
  shape.separator = best_separator(lines);
  const Table table(lines, shape.separator);
  const Body body = body_of(table);
  shape.columns = body.columns;
  shape.rows = lines.size();
  for (std::size_t i = lines.size(); i-- > 0;)
    if (is_row(table, i, body)) shape.rows = i;
  if (shape.rows == lines.size()) {  // no row has numbers: the first line is the header, as in an empty table
    shape.header = 0;
    shape.rows = 1;
    return shape;
  }
  if (shape.rows == 0) {
    shape.header_in_comment = names_in_comment(lines.front(), shape);
    return shape;
  }
  find_header(shape, table, body);
  return shape;
}

}  // namespace tumble::csv
