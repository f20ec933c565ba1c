#include "tumble/formats/csv/layout.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>

#include "tumble/formats/csv/number.hpp"
#include "tumble/formats/file/annotations.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::csv {

namespace {

const std::string not_read = "-";  ///< in place of the name of a column

bool blank(char c) { return c == ' ' || c == '\t'; }

std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  auto line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

/// "clock: {"start": 0, "rate": 100}" [s], [Hz].
std::optional<Timeline> clock_from(std::string_view json) {
  const auto parsed = nlohmann::json::parse(json, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("start") || !parsed.contains("rate")) return std::nullopt;
  const auto& start = parsed["start"];
  const auto& rate = parsed["rate"];
  if (!start.is_number() || !rate.is_number() || !(rate.get<double>() > 0.0)) return std::nullopt;
  return Timeline{start.get<double>(), rate.get<double>(), nullptr};
}

/// A comment line may carry what our writer put there: "# marks: [...]". Anything else is for people.
void take_comment(Layout& layout, std::string_view line) {
  line = trimmed(line.substr(1));
  const auto colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const auto key = line.substr(0, colon);
  const auto json = line.substr(colon + 1);
  if (key == "clock") {
    if (auto clock = clock_from(json)) layout.clock = clock;
  } else {
    file::annotate(layout.annotations, layout.kinds, key, json);
  }
}

/// Tabs, semicolons and commas outside quotes and units separate, in this order of preference; else blanks.
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

bool is_number(const std::string& cell) {
  double value = 0.0;
  return !cell.empty() && fast_float::from_chars(cell.data(), cell.data() + cell.size(), value).ec == std::errc();
}

/// "name[unit]"; the unit is empty where there is none.
std::pair<std::string, std::string> name_and_unit(const std::string& cell) {
  const auto open = cell.rfind('[');
  if (open == std::string::npos || !cell.ends_with(']')) return {cell, ""};
  return {std::string(trimmed(std::string_view(cell).substr(0, open))),
          std::string(trimmed(std::string_view(cell).substr(open + 1, cell.size() - open - 2)))};
}

/// "time" in any case, or "t" in a unit of time ("T" is a temperature).
bool is_time(const std::string& name, const std::string& unit) {
  if (name == "t") {
    for (const char* known : {"s", "ms", "us", "ns", "min", "h"})
      if (unit == known) return true;
    return false;
  }
  const char* const time = "time";
  return name.size() == 4 && std::equal(name.begin(), name.end(), time,
                                        [](unsigned char c, char expected) { return std::tolower(c) == expected; });
}

struct Header {
  const std::string& path;
  const ReadOptions& options;
  std::vector<std::string> problems;
  std::vector<std::string> without_unit;

  bool wanted(const std::string& name) const {
    return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end();
  }

  Column column(const std::string& cell, std::size_t number) {
    const auto [name, unit] = name_and_unit(cell);
    Column result{name, {}, is_time(name, unit), true};
    result.label = !name.empty() && name == options.segment_column;
    if (result.label || cell == not_read) return {name, {}, false, false, result.label};
    result.wanted = result.time || wanted(name);
    const std::string where = "column " + std::to_string(number) + " '" + cell + "': ";
    if (name.empty()) problems.push_back(where + "it has no name");
    if (name.empty() || !result.wanted) return result;
    const auto given = options.units.find(name);
    try {
      if (!unit.empty())
        result.unit = Unit::parse(unit);
      else if (given != options.units.end())
        result.unit = given->second;
      else
        without_unit.push_back(name);
    } catch (const Error& error) {
      problems.push_back(where + error.what());
    }
    const bool known = !unit.empty() || given != options.units.end();
    if (result.time && known && problems.empty() && kind_of(result.unit) != QuantityKind::time)
      problems.push_back(where + "time is expected in s, ms, us, ns, min or h");
    return result;
  }

  void finish() {
    if (!without_unit.empty()) {
      std::string names;
      for (const auto& name : without_unit) names += (names.empty() ? "'" : ", '") + name + "'";
      const auto& one = without_unit.front();
      const std::string example = is_time(one, "") ? "[s]" : "[deg/h]";
      problems.push_back((without_unit.size() == 1 ? "column without a unit: " : "columns without a unit: ") + names +
                         "; write it in the header, for example " + one + example +
                         ", or in the plan's [channels] table: role = \"" + one + example +
                         "\", or give it: --set unit." + one + "=" + example.substr(1, example.size() - 2) +
                         " (=1 for plain numbers)");
    }
    if (problems.empty()) return;
    problems.front() = "'" + path + "', header: " + problems.front();
    throw Error{Error::Kind::bad_file, problems};
  }
};

/// One time column at most, and no name twice.
void check_names(const std::vector<Column>& columns, std::vector<std::string>& problems) {
  std::set<std::string> seen;
  bool time = false;
  for (const Column& column : columns) {
    if (column.name != not_read && !seen.insert(column.name).second)
      problems.push_back("the column name '" + column.name + "' stands twice");
    if (column.time && time) problems.push_back("there are two time columns; '" + column.name + "' is one too many");
    time = time || column.time;
  }
}

/// The column that was said to hold the labels must be there.
void check_label(const std::vector<Column>& columns, const std::string& label, std::vector<std::string>& problems) {
  if (label.empty() || std::ranges::any_of(columns, &Column::label)) return;
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  std::string problem = "no column '" + label + "' for segment_column" + did_you_mean(label, names) + "; columns are";
  for (const auto& name : names) problem += (name == names.front() ? " " : ", ") + name;
  problems.push_back(problem);
}

/// Names for so many columns, to show how they are written.
std::string example_columns(std::size_t count) {
  const std::string accelerometer = "accelerometer_x[m/s^2],accelerometer_y[m/s^2],accelerometer_z[m/s^2]";
  const std::string gyro = "gyro_x[deg/s],gyro_y[deg/s],gyro_z[deg/s]";
  if (count == 1) return "gyro[deg/s]";
  if (count == 3) return accelerometer;
  if (count == 4) return "time[s]," + accelerometer;
  if (count == 6) return accelerometer + "," + gyro;
  std::string text = "time[s]";
  if (count >= 7) text += "," + accelerometer + "," + gyro;
  for (std::size_t i = count >= 7 ? 7 : 1; i < count; ++i) text += i == 1 ? ",gyro[deg/s]" : ",-";
  return text;
}

/// The line for a message: short, and nothing a terminal would act on.
std::string shown(std::string_view line) {
  std::string text(trimmed(line));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return "\"" + (text.size() > 60 ? text.substr(0, 60) + "..." : text) + "\"";
}

[[noreturn]] void refuse_no_header(const std::string& where, std::string_view line, std::size_t count) {
  const auto columns = std::to_string(count) + (count == 1 ? " column" : " columns");
  const auto example = example_columns(count);
  std::string listed = "\"" + example + "\"";
  for (std::size_t at = 0; (at = listed.find(',', at)) != std::string::npos; at += 4) listed.replace(at, 1, "\", \"");
  throw Error{Error::Kind::bad_file,
              where + ": numbers where the header is expected, " + columns + ": " + shown(line) +
                  "; name each column as name[unit], or - for a column to skip: --set columns=\"" + example +
                  "\", or in the plan, [[recording]] columns = [" + listed + "]"};
}

/// Whether the first line holds samples, now that its columns are known: what is to be a number looks like one.
bool samples_in(const std::vector<std::string>& cells, const ReadOptions& options) {
  for (std::size_t i = 0; i < std::min(cells.size(), options.columns.size()); ++i) {
    const auto& column = options.columns[i];
    const bool number = column != not_read && name_and_unit(column).first != options.segment_column;
    if (number && !cells[i].empty() && cells[i] != options.missing && !is_number(cells[i])) return false;
  }
  return true;
}

/// The columns given take the place of the file's own header; a unit that it says and they do not is a problem.
void replace_header(Layout& layout, std::string_view line, const std::vector<std::string>& cells, Header& header) {
  const auto& columns = header.options.columns;
  for (std::size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
    const auto own = name_and_unit(cells[i]).second, said = name_and_unit(columns[i]).second;
    if (!own.empty() && !said.empty() && own != said)
      header.problems.push_back("column " + std::to_string(i + 1) + " is '" + cells[i] + "' in the file, but '" +
                                columns[i] + "' was given; one is wrong");
  }
  layout.annotations.findings.push_back(
      {Finding::Severity::info, "header_replaced", {{"header", shown(line)}}, header.path});
}

/// False where the line holds samples, and options.columns stand for the header that is not there.
bool take_header(Layout& layout, std::string_view line, const std::string& path, const ReadOptions& options) {
  if (line.find('\0') != std::string_view::npos)
    throw Error{Error::Kind::bad_file, "'" + path +
                                           "' is not a text table: its header holds zero bytes (text must be "
                                           "UTF-8 or ASCII, not UTF-16)"};
  if (line.find('\r') != std::string_view::npos)
    throw Error{Error::Kind::bad_file, "'" + path + "': its lines end with CR alone; LF or CR LF is expected"};
  layout.separator = separator_of(line);
  auto cells = cells_of(line, layout.separator);
  const std::size_t most = cells.size();  // cells at the end that are empty may be columns, or no more than separators
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  const std::string where = "'" + path + "', line " + std::to_string(layout.lines);
  if (options.columns.empty() && std::all_of(cells.begin(), cells.end(), is_number))
    refuse_no_header(where, line, cells.size());
  const bool headed = options.columns.empty() || !samples_in(cells, options);
  Header header{path, options, {}, {}};
  if (const std::size_t named = options.columns.size(); named > 0) {
    if (named < cells.size() || named > most)
      throw Error{Error::Kind::bad_file, where + ": " + std::to_string(cells.size()) +
                                             (cells.size() == 1 ? " column" : " columns") + ", but columns names " +
                                             std::to_string(named) + ": " + shown(line)};
    if (headed) replace_header(layout, line, cells, header);
    cells = options.columns;
  }
  for (std::size_t i = 0; i < cells.size(); ++i) layout.columns.push_back(header.column(cells[i], i + 1));
  check_names(layout.columns, header.problems);
  check_label(layout.columns, options.segment_column, header.problems);
  header.finish();
  return headed;
}

/// The one mark in a cell of digits: 0 where there is none. A date has several, and says nothing.
char mark_in(std::string_view cell) {
  if (cell.find_first_not_of("+-0123456789.,eE") != std::string_view::npos) return 0;
  const std::size_t first = cell.find_first_of(".,");
  const bool alone = first != std::string_view::npos && cell.find_first_of(".,", first + 1) == std::string_view::npos;
  return alone ? cell[first] : '\0';
}

/// As the user says. Else the comma where it does not separate, numbers among the first samples have it, and none has
/// the point.
char decimal_mark(std::string_view text, char separator, char said) {
  if (said != 0) return said;
  if (separator == ',') return '.';
  bool comma = false;
  text = text.substr(0, 65536);
  while (!text.empty()) {
    const auto line = take_line(text);
    if (trimmed(line).starts_with('#')) continue;
    for (const auto& cell : cells_of(line, separator)) {
      const char mark = mark_in(cell);
      if (mark == '.') return '.';
      comma = comma || mark == ',';
    }
  }
  return comma ? ',' : '.';
}

/// Commas cannot be both.
void check_mark(char separator, const ReadOptions& options, const std::string& where) {
  if (separator == ',' && options.decimal == ',')
    throw Error{
        Error::Kind::bad_file,
        where + ": the comma separates the columns here, so that it cannot be the decimal mark (decimal=comma)"};
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && (blank(text.back()) || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  if (separator == ' ') line = trimmed(line);
  std::string cell;
  bool quoted = false;
  const auto finish = [&] {
    cells.emplace_back(trimmed(cell));
    cell.clear();
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool separates = separator == ' ' ? blank(c) : c == separator;
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cell += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (separates && !quoted) {
      finish();
      while (separator == ' ' && i + 1 < line.size() && blank(line[i + 1])) ++i;
    } else {
      cell += c;
    }
  }
  finish();
  return cells;
}

Layout read_layout(const std::string& path, std::string_view& text, const ReadOptions& options) {
  if (text.empty()) throw Error{Error::Kind::bad_file, "'" + path + "' is empty"};
  Layout layout;
  while (!text.empty()) {
    const auto before = text;
    const auto line = take_line(text);
    ++layout.lines;
    const auto content = trimmed(line);
    if (content.empty()) continue;
    if (content.front() == '#') {
      take_comment(layout, content);
      continue;
    }
    if (!take_header(layout, line, path, options)) {
      text = before;
      --layout.lines;
    }
    check_mark(layout.separator, options, "'" + path + "', line " + std::to_string(layout.lines));
    layout.mark = decimal_mark(text, layout.separator, options.decimal);
    return layout;
  }
  throw Error{Error::Kind::bad_file, "'" + path +
                                         "' has no header line: one name[unit] for each column is expected, for "
                                         "example time[s],gyro[deg/h]"};
}

}  // namespace tumble::csv
