#include "tumble/formats/csv/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "tumble/formats/csv/advice.hpp"
#include "tumble/formats/csv/shape.hpp"
#include "tumble/formats/file/annotations.hpp"
#include "tumble/language/say.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::csv {

namespace {

constexpr std::size_t lines_seen = 300;                   // of the table, to recognise it
constexpr std::size_t marks_seen = std::size_t{1} << 16;  // [bytes] of samples, to find the decimal mark

std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  auto line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  while (line.ends_with('\r')) line.remove_suffix(1);
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

/// A line for a message: short, and nothing a terminal would act on.
std::string shown(std::string_view line) { return "\"" + plain_text(line, 60) + "\""; }

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

[[noreturn]] void refuse_no_header(const Where& where, std::string_view line, std::size_t count) {
  const auto example = example_columns(count);
  std::string listed = "\"" + example + "\"";
  for (std::size_t at = 0; (at = listed.find(',', at)) != std::string::npos; at += 4) listed.replace(at, 1, "\", \"");
  throw Error{
      Error::Kind::bad_file,
      Problem(where, say("numbers where the header is expected, {}: {}; name each column as name[unit], or - for "
                         "a column to skip: --set columns=\"{}\", or in the plan, [[recording]] columns = [{}]",
                         said_count(count, "column"), Name{shown(line)}, example, Name{listed}))};
}

/// What the header gives: columns, and what is wrong with them.
struct Header {
  const std::string& path;
  const ReadOptions& options;
  std::vector<ColumnName> names;
  std::vector<ColumnSample> samples;
  Clock clock;
  Problems problems;
  std::vector<std::string> proposals;
  std::vector<std::size_t> without_unit;
  std::vector<std::pair<std::size_t, std::string>> skipped;  ///< columns, and why

  bool wanted(const std::string& name) const {
    return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end();
  }

  /// Why a column without a unit is not read; empty: it is to be read.
  std::string reason_to_skip(std::size_t index) const {
    const ColumnName& name = names[index];
    if (!name.unit.empty() && name.from != UnitFrom::row) return "";
    if (name.cell.empty()) return "no name";
    if (std::ranges::find(clock.others, index) != clock.others.end()) return "another clock";
    if (!name.unit.empty()) return "";
    if (const auto reason = no_signal(name.name); !reason.empty()) return std::string(reason);
    return samples[index].text ? "text" : samples[index].empty && index > 0 ? "blank" : "";
  }

  Unit unit_of(std::size_t index, const Where& where) {
    const ColumnName& name = names[index];
    const std::string& unit = index == clock.first() && !clock.unit.empty() ? clock.unit : name.unit;
    if (unit.empty()) {
      without_unit.push_back(index);
      return {};
    }
    try {
      const auto given = options.units.find(name.name);
      if (name.from == UnitFrom::options && given != options.units.end()) return given->second;
      return parse_written_unit(unit);
    } catch (const Error& error) {
      const auto given = options.units.find(name.name);
      const bool of_file = name.from == UnitFrom::row || name.from == UnitFrom::brackets;
      if (of_file && given != options.units.end()) return given->second;
      for (const auto& problem : error.problems) problems.push_back(within(where, problem));
      if (of_file) proposals.push_back("unit." + name.name + "=" + likely_unit(name.name, samples[index].greatest));
      return {};
    }
  }

  Column column(std::size_t index) {
    const ColumnName& name = names[index];
    Column result{name.name, {}, index == clock.first() && !clock.stamped(), true};
    result.label = !name.name.empty() && name.name == options.segment_column;
    const bool stamp = clock.stamped() && clock.uses(index);
    if (result.label || stamp || name.cell == not_read) return {name.name, {}, false, false, result.label, false};
    result.wanted = result.time || wanted(name.name);
    const Where where{.file = path,
                      .column = index + 1,
                      .channel = name.name,
                      .place = say("column {} '{}'", index + 1, Name{plain_text(name.cell, 60)})};
    if (const auto reason = result.time ? "" : reason_to_skip(index);
        !reason.empty() && options.columns.empty() && (options.only.empty() || !wanted(name.name))) {
      skipped.emplace_back(index, reason);
      result.wanted = result.signal = false;
    }
    if (name.name.empty() && !name.cell.empty()) problems.emplace_back(where, "it has no name");
    if (name.name.empty() || !result.wanted) return result;
    const std::size_t before = problems.size(), unknown = without_unit.size();
    result.unit = unit_of(index, where);
    if (result.time && problems.size() == before && without_unit.size() == unknown &&
        kind_of(result.unit) != QuantityKind::time)
      problems.emplace_back(where, "time is expected in s, ms, us, ns, min or h");
    return result;
  }

  void note_without_unit() {
    if (without_unit.empty()) return;
    std::vector<Sentence> named;
    for (const std::size_t index : without_unit) {
      named.push_back(say("'{}'", plain_text(names[index].name, 60)));
      const std::string likely = index == clock.first() ? likely_clock_unit(samples[index])
                                                        : likely_unit(names[index].name, samples[index].greatest);
      proposals.push_back("unit." + names[index].name + "=" + likely);
    }
    const std::string one = plain_text(names[without_unit.front()].name, 60);
    const std::string likely = likely_unit(one, samples[without_unit.front()].greatest);
    const std::string example = without_unit.front() == clock.first()
                                    ? "[" + likely_clock_unit(samples[without_unit.front()]) + "]"
                                : likely == "1" ? "[deg/h]"
                                                : "[" + likely + "]";
    problems.push_back(say(
        "{}: {}; write it in the header, for example {}{}, or in the plan's [channels] table: role = \"{}{}\", or "
        "give it: --set unit.{}={} (=1 for plain numbers)",
        without_unit.size() == 1 ? "column without a unit" : "columns without a unit", in_a_row(named, ", "), Name{one},
        Name{example}, Name{one}, Name{example}, Name{one}, Name{example.substr(1, example.size() - 2)}));
  }

  void finish() {
    note_without_unit();
    if (problems.empty()) return;
    problems.front() = within(Where{.file = path, .place = say("'{}', header", Name{path})}, problems.front());
    if (!proposals.empty())
      problems.push_back(say("to copy, with units to be checked: {}", Name{command_line(path, options, proposals)}));
    throw Error{Error::Kind::bad_file, problems};
  }
};

/// One time column at most, and no name twice.
void check_names(const std::vector<Column>& columns, Problems& problems) {
  std::set<std::string> seen;
  for (const Column& column : columns)
    if (column.name != not_read && !column.name.empty() && column.wanted && !seen.insert(column.name).second)
      problems.push_back(say("the column name '{}' stands twice", plain_text(column.name, 60)));
}

/// The column that was said to hold the labels must be there.
void check_label(const std::vector<Column>& columns, const std::string& label, Problems& problems) {
  if (label.empty() || std::ranges::any_of(columns, &Column::label)) return;
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  problems.push_back(say("no column '{}' for segment_column{}; columns are {}", label, did_you_mean(label, names),
                         fmt::join(names, ", ")));
}

/// The columns given take the place of the file's own header; a unit that it says and they do not is a problem.
void replace_header(Layout& layout, std::string_view line, const std::vector<std::string>& cells, Header& header) {
  const auto& columns = header.options.columns;
  for (std::size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
    const auto own = name_and_unit(cells[i]).unit, said = name_and_unit(columns[i]).unit;
    if (!own.empty() && !said.empty() && own != said)
      header.problems.push_back(say("column {} is '{}' in the file, but '{}' was given; one is wrong",
                                    Name{std::to_string(i + 1)}, plain_text(cells[i], 60), columns[i]));
  }
  layout.annotations.findings.push_back(
      {Finding::Severity::info, "header_replaced", {{"header", shown(line)}}, header.path});
}

/// The one mark in a cell of digits: 0 where there is none. A date has several, and says nothing.
char mark_in(std::string_view cell) {
  if (cell.find_first_not_of("+-0123456789.,eE") != std::string_view::npos) return 0;
  const std::size_t first = cell.find_first_of(".,");
  const bool alone = first != std::string_view::npos && cell.find_first_of(".,", first + 1) == std::string_view::npos;
  return alone ? cell[first] : '\0';
}

/// As the user says. Else the comma where it does not separate, numbers among the first samples have it, and none has
/// the point. The cells of a clock say nothing: they are read with either.
char decimal_mark(std::string_view text, const Layout& layout, char said) {
  if (said != 0) return said;
  if (layout.separator == ',') return '.';
  bool comma = false;
  text = text.substr(0, marks_seen);
  while (!text.empty()) {
    const auto line = take_line(text);
    if (trimmed(line).starts_with('#')) continue;
    const auto cells = cells_of(line, layout.separator);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i < layout.columns.size() && !layout.columns[i].signal) continue;
      const char mark = mark_in(cells[i]);
      if (mark == '.') return '.';
      comma = comma || mark == ',';
    }
  }
  return comma ? ',' : '.';
}

/// Commas cannot be both.
void check_mark(char separator, const ReadOptions& options, const Where& where) {
  if (separator == ',' && options.decimal == ',')
    throw Error{
        Error::Kind::bad_file,
        Problem(where, "the comma separates the columns here, so that it cannot be the decimal mark (decimal=comma)")};
}

/// The line must be one of a text table.
void check_text(const std::string& path, std::string_view line) {
  if (line.find('\0') != std::string_view::npos)
    throw Error{Error::Kind::bad_file, say("'{}' is not a text table: its header holds zero bytes", path)};
  while (line.ends_with('\r')) line.remove_suffix(1);
  if (line.find('\r') != std::string_view::npos)
    throw Error{Error::Kind::bad_file,
                say("'{}': some of its lines end with CR alone; LF or CR LF is expected in all of them", path)};
}

/// Cells of the header, without empty ones at its end that no column of the rows needs.
std::vector<std::string> header_cells(std::string_view line, char separator) {
  auto cells = cells_of(line, separator);
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  return cells;
}

/// The names of the columns: those given, those of the header, or those of the comment before the first row.
std::vector<std::string> names_of(Layout& layout, const std::vector<TextLine>& lines, const Shape& shape,
                                  Header& header) {
  const ReadOptions& options = header.options;
  const TextLine& first = lines[shape.header ? *shape.header : std::min(shape.rows, lines.size() - 1)];
  const Where where{
      .file = header.path, .line = first.number, .place = say("'{}', line {}", header.path, first.number)};
  check_text(header.path, first.text);
  const auto own = cells_of(first.text, shape.separator);
  const auto cells = header_cells(first.text, shape.separator);
  if (options.columns.empty() && shape.header) return cells;
  if (options.columns.empty() && shape.header_in_comment) return cells_of(first.before, shape.separator);
  if (options.columns.empty()) refuse_no_header(where, first.text, cells.size());
  const std::size_t named = options.columns.size();
  if (named < cells.size() || named > own.size())
    throw Error{Error::Kind::bad_file,
                Problem(where, say("{}, but columns names {}: {}", said_count(cells.size(), "column"), named,
                                   Name{shown(first.text)}))};
  if (shape.header) replace_header(layout, first.text, cells, header);
  return options.columns;
}

/// Columns, clock and units; throws with all that is wrong.
void take_columns(Layout& layout, const std::vector<TextLine>& lines, const Shape& shape, Header& header) {
  const bool given = !header.options.columns.empty();
  const auto cells = names_of(layout, lines, shape, header);
  const auto units =
      shape.units && !given ? cells_of(lines[*shape.units].text, shape.separator) : std::vector<std::string>();
  header.names = column_names(cells, units, header.options, given);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = shape.rows; i < lines.size(); ++i) rows.push_back(cells_of(lines[i].text, shape.separator));
  header.samples = sampled(rows, cells.size());
  header.clock = clock_of(header.names, header.samples, header.options, header.problems, header.proposals);
  for (std::size_t i = 0; i < cells.size(); ++i) layout.columns.push_back(header.column(i));
  check_names(layout.columns, header.problems);
  check_label(layout.columns, header.options.segment_column, header.problems);
  header.finish();
  layout.stamp = header.clock;
}

/// Lines that the user says come before the table.
void skip_lines(Layout& layout, std::string_view& text, std::size_t count) {
  for (; layout.lines < count && !text.empty(); ++layout.lines) take_line(text);
}

}  // namespace

Layout read_layout(const std::string& path, std::string_view& text, const ReadOptions& options,
                   const Encoding& encoding) {
  if (text.empty()) throw Error{Error::Kind::bad_file, say("'{}' is empty", path)};
  Layout layout;
  skip_lines(layout, text, options.skip);
  const auto lines = first_lines(text, layout.lines + 1, lines_seen);
  if (lines.empty())
    throw Error{
        Error::Kind::bad_file,
        say("'{}' has no header line: one name[unit] for each column is expected, for example time[s],gyro[deg/h]",
            path)};
  const Shape shape = shape_of(lines, options);
  layout.separator = shape.separator;
  const std::size_t last = (shape.rows < lines.size() ? lines[shape.rows].number : lines.back().number + 1) - 1;
  while (layout.lines < last && !text.empty()) {
    const auto content = trimmed(take_line(text));
    ++layout.lines;
    if (content.starts_with('#')) take_comment(layout, content);
  }
  Header header{path, options, {}, {}, {}, {}, {}, {}, {}};
  take_columns(layout, lines, shape, header);
  const std::size_t begins = shape.header ? lines[*shape.header].number : layout.lines;
  check_mark(layout.separator, options, {.file = path, .line = begins, .place = say("'{}', line {}", path, begins)});
  layout.mark = decimal_mark(text, layout, options.decimal);
  say_what_was_recognised(layout,
                          {path, options, encoding, lines, shape, header.names, header.samples, header.skipped});
  return layout;
}

}  // namespace tumble::csv
