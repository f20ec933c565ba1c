#include "tumble/formats/csv/advice.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/units/text_parts.hpp"

namespace tumble::csv {

namespace {

/// key=value for what the options say.
std::vector<std::string> said(const ReadOptions& options) {
  std::vector<std::string> sets;
  const auto add = [&](const char* key, const std::string& value) {
    if (!value.empty()) sets.push_back(std::string(key) + "=" + value);
  };
  if (options.rate) add("rate", fmt::format("{}", *options.rate));
  add("columns", joined(options.columns, ","));
  add("segment_column", options.segment_column);
  add("missing", options.missing);
  add("decimal", options.decimal == ',' ? "comma" : options.decimal == '.' ? "point" : "");
  add("encoding", options.encoding);
  add("time", options.time);
  add("date", options.date);
  if (options.skip > 0) add("skip", std::to_string(options.skip));
  for (const auto& [column, unit] : options.units) sets.push_back("unit." + column + "=" + unit.text());
  return sets;
}

const char* separator_name(char separator) {
  switch (separator) {
    case '\t':
      return "tab";
    case ';':
      return "semicolon";
    case ' ':
      return "blanks";
    default:
      return "comma";
  }
}

/// Names of the columns whose unit stands there, with their units.
std::string units_from(const Understood& table, UnitFrom from) {
  std::vector<std::string> units;
  for (const ColumnName& name : table.names)
    if (name.from == from) units.push_back(in_quotes(name.name) + " in " + plain_text(name.unit, 20));
  return joined(units);
}

/// Lines before the samples that are neither header nor units nor comments.
std::vector<std::size_t> skipped_lines(const Understood& table) {
  std::vector<std::size_t> skipped;
  for (std::size_t i = 0; i < table.shape.rows && i < table.lines.size(); ++i)
    if (table.shape.header != i && table.shape.units != i) skipped.push_back(i);
  return skipped;
}

/// Findings and entries of the list, one after the other.
struct Notes {
  Layout& layout;
  const Understood& table;
  bool plain = true;

  void find(const char* code, std::vector<FindingValue> values) {
    layout.annotations.findings.push_back({Finding::Severity::info, code, std::move(values), table.path});
    plain = false;
  }
  void list(const std::string& what, const std::string& how) { layout.annotations.recognised.push_back({what, how}); }

  void text() {
    if (table.encoding.recognised)
      find("text_encoding", {{"encoding", table.encoding.name}});
    else if (table.encoding.name != "UTF-8" || table.encoding.return_ends)
      plain = false;
    if (layout.mark == ',') decimal_comma();
  }

  /// Says which number was read, where every comma could also separate thousands.
  void decimal_comma() {
    const auto grouped = std::ranges::find_if(table.samples, [](const auto& s) { return !s.grouped.empty(); });
    const bool open = table.options.decimal == 0 && std::ranges::none_of(table.samples, &ColumnSample::decimal_commas);
    if (!open || grouped == table.samples.end()) return find("decimal_comma", {});
    std::string number = grouped->grouped;
    std::ranges::replace(number, ',', '.');
    find("decimal_comma_or_thousands", {{"written", grouped->grouped}, {"number", number}});
  }

  void header() {
    if (const auto lines = skipped_lines(table); !lines.empty())
      find("lines_before_samples_skipped",
           {{"skipped", lines.size()}, {"first", "\"" + plain_text(table.lines[lines.front()].text, 60) + "\""}});
    if (table.shape.header_in_comment && table.options.columns.empty()) find("header_in_comment", {});
    if (table.shape.units)
      find("units_row", {{"line", table.lines[*table.shape.units].number},
                         {"row", "\"" + plain_text(table.lines[*table.shape.units].text, 60) + "\""}});
    if (const auto words = units_from(table, UnitFrom::words); !words.empty())
      find("units_in_words", {{"units", words}});
    if (const auto ros = units_from(table, UnitFrom::convention); !ros.empty())
      find("units_by_convention", {{"units", ros}});
  }

  void clock() {
    if (!layout.stamp.how.empty()) find("clock_recognised", {{"clock", layout.stamp.how}});
  }

  void columns() {
    if (!table.options.only.empty()) return;
    std::vector<std::string> texts;
    for (const auto& [index, reason] : table.skipped)
      texts.push_back((table.names[index].cell.empty() ? "column " + std::to_string(index + 1)
                                                       : in_quotes(table.names[index].name)) +
                      " (" + reason + ")");
    if (!texts.empty()) find("columns_not_read", {{"columns", joined(texts)}});
    for (const auto& [index, reason] : table.skipped)
      if (reason == "text" && names_segments(table.names[index].name) && table.options.segment_column.empty()) {
        find("segment_column_proposed", {{"column", plain_text(table.names[index].name, 60)}});
        break;
      }
  }

  /// The options that say in words what was recognised.
  std::vector<std::string> options() const {
    std::vector<std::string> sets;
    if (table.encoding.recognised && table.options.encoding.empty())
      sets.push_back("encoding=" + lower_case(table.encoding.name));
    if (layout.mark == ',' && table.options.decimal == 0) sets.emplace_back("decimal=comma");
    if (!layout.stamp.how.empty() && table.options.time.empty())
      sets.push_back("time=" + table.names[layout.stamp.first()].name);
    return sets;
  }

  void summary() {
    list("encoding", table.encoding.name + (table.encoding.recognised ? ", by its bytes" : "") +
                         (table.encoding.return_ends ? ", lines end with CR" : ""));
    list("separator", separator_name(layout.separator));
    list("decimal mark", layout.mark == ',' ? "comma" : "point");
    if (table.shape.header)
      list("header", "line " + std::to_string(table.lines[*table.shape.header].number));
    else
      list("header", table.options.columns.empty() ? "the comment before the first row" : "columns as given");
    if (table.shape.units) list("units", "line " + std::to_string(table.lines[*table.shape.units].number));
    if (!layout.stamp.columns.empty())
      list("clock", layout.stamp.how.empty() ? in_quotes(table.names[layout.stamp.first()].name) + " in " +
                                                   table.names[layout.stamp.first()].unit
                                             : layout.stamp.how);
    for (const auto& [index, reason] : table.skipped)
      list("not read", (table.names[index].cell.empty() ? "column " + std::to_string(index + 1)
                                                        : in_quotes(table.names[index].name)) +
                           ": " + reason);
    if (const auto sets = options(); !sets.empty())
      list(
          "say it with", "--set " + [&] {
            std::string text;
            for (const auto& set : sets) text += (text.empty() ? "" : " --set ") + shell_word(set);
            return text;
          }());
  }
};

}  // namespace

std::string command_line(const std::string& path, const ReadOptions& options, const std::vector<std::string>& further) {
  std::string line = "tumble inspect " + shell_word(path);
  for (const auto& set : said(options)) line += " --set " + shell_word(set);
  for (const auto& set : further) line += " --set " + shell_word(set);
  return line;
}

void say_what_was_recognised(Layout& layout, const Understood& table) {
  Notes notes{layout, table};
  notes.text();
  notes.header();
  notes.clock();
  notes.columns();
  if (!notes.plain) notes.summary();
}

std::string likely_clock_unit(const ColumnSample& sample) {
  constexpr double earliest = 30'000.0, latest = 80'000.0, densest = 1e-3;  // days since 1900 of a worksheet
  if (sample.first > earliest && sample.last < latest && sample.step < densest) return "day";
  return sample.step <= 2.0 ? "s" : sample.step < 500.0 ? "ms" : sample.step < 2e5 ? "us" : "ns";
}

}  // namespace tumble::csv
