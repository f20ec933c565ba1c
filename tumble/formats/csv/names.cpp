#include "tumble/formats/csv/names.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/shape.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

bool only_digits(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789,; ") == std::string::npos;
}

bool parses(const std::string& unit) {
  try {
    parse_written_unit(unit);
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// "Zeit (s)", "时间（s）", "T / degC", "Zeit in s": the unit behind the name, if it is one.
std::optional<Named> unit_in_words(const std::string& cell) {
  const auto split = [&](std::size_t name_end, std::size_t unit_begin, std::size_t unit_end) -> std::optional<Named> {
    const std::string name(trimmed(std::string_view(cell).substr(0, name_end)));
    const std::string unit(trimmed(std::string_view(cell).substr(unit_begin, unit_end - unit_begin)));
    if (name.empty() || unit.empty() || only_digits(unit) || !parses(unit)) return std::nullopt;
    return Named{name, unit};
  };
  if (cell.ends_with(')')) {
    int depth = 0;
    for (std::size_t i = cell.size(); i-- > 0;) {
      depth += (cell[i] == ')') - (cell[i] == '(');
      if (depth == 0) return split(i, i + 1, cell.size() - 1);
    }
    return std::nullopt;
  }
  if (const std::string_view open = "（", close = "）"; cell.ends_with(close))
    if (const auto at = cell.rfind(open); at != std::string::npos)
      return split(at, at + open.size(), cell.size() - close.size());
  // The longest unit: "gyro x in deg / s" is not "gyro x in deg" in s.
  for (std::size_t at = 0; at < cell.size(); ++at)
    for (const std::string_view between : {" / ", " in "})
      if (cell.compare(at, between.size(), between) == 0)
        if (auto named = split(at, at + between.size(), cell.size())) return named;
  return std::nullopt;
}

/// sensor_msgs of ROS define their units: REP 103.
std::string unit_of_ros(const std::string& name) {
  if (name.size() < 3) return "";
  const std::string_view axes = "xyzw", joints = "./_";
  if (axes.find(name.back()) == axes.npos || joints.find(name[name.size() - 2]) == joints.npos) return "";
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> fields{
      {{"angular_velocity", "rad/s"}, {"linear_acceleration", "m/s^2"}, {"magnetic_field", "T"}, {"orientation", "1"}}};
  const std::string_view before = std::string_view(name).substr(0, name.size() - 2);
  for (const auto& [field, unit] : fields)
    if (before.ends_with(field) &&
        (before.size() == field.size() || joints.find(before[before.size() - field.size() - 1]) != joints.npos))
      return std::string(unit);
  return "";
}

bool holds(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words, [&](std::string_view word) { return text.find(word) != text.npos; });
}

/// How many cells have that name before a bracket with digits: gyro[0], gyro[1].
std::map<std::string, int> indexed_names(const std::vector<std::string>& cells) {
  std::map<std::string, int> counts;
  for (const std::string& cell : cells)
    if (const Named named = name_and_unit(cell); only_digits(named.unit)) ++counts[named.name];
  return counts;
}

/// The unit behind the last _ of a name, as programs write it: "ax_g", "gyro_x_lsb"; empty where there is none.
std::string_view unit_at_end(std::string_view lower) {
  const auto at = lower.find_last_of("_ ");
  if (at == lower.npos) return "";
  for (const auto& [end, unit] : std::initializer_list<std::pair<std::string_view, std::string_view>>{{"g", "g"},
                                                                                                      {"mg", "mg"},
                                                                                                      {"mps2", "m/s^2"},
                                                                                                      {"ms2", "m/s^2"},
                                                                                                      {"dps", "deg/s"},
                                                                                                      {"rads", "rad/s"},
                                                                                                      {"c", "degC"},
                                                                                                      {"degc", "degC"},
                                                                                                      {"v", "V"},
                                                                                                      {"mv", "mV"},
                                                                                                      {"lsb", "LSB"},
                                                                                                      {"raw", "LSB"}})
    if (lower.substr(at + 1) == end) return unit;
  return "";
}

}  // namespace

Unit parse_written_unit(const std::string& text) {
  // As people write them: nobody means one over the square of a millisecond.
  for (const auto& [written, unit] :
       std::initializer_list<std::pair<std::string_view, const char*>>{{"ms-2", "m/s^2"},
                                                                       {"ms^-2", "m/s^2"},
                                                                       {"ms⁻²", "m/s^2"},
                                                                       {"rads-1", "rad/s"},
                                                                       {"rads^-1", "rad/s"},
                                                                       {"rads⁻¹", "rad/s"}})
    if (text == written) return Unit::parse(unit);
  try {
    return Unit::parse(text);
  } catch (const Error&) {
    std::string other;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool power = text[i] == '-' && i > 0 && std::isalpha(static_cast<unsigned char>(text[i - 1])) != 0 &&
                         i + 1 < text.size() && std::isdigit(static_cast<unsigned char>(text[i + 1])) != 0;
      other += text[i] == ' ' || text[i] == '.' ? "*" : power ? "^-" : std::string(1, text[i]);
    }
    if (other == text) throw;
    try {
      return Unit::parse(other);
    } catch (const Error&) {
    }
    throw;
  }
}

std::vector<ColumnName> column_names(const std::vector<std::string>& cells, const std::vector<std::string>& units,
                                     const ReadOptions& options, bool only_brackets) {
  const auto indexed = indexed_names(cells);
  std::vector<ColumnName> names;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Named named = name_and_unit(cells[i]);
    ColumnName column{cells[i], named.name, named.unit, named.unit.empty() ? UnitFrom::nowhere : UnitFrom::brackets};
    if (only_digits(named.unit) &&
        (named.unit != "1" || indexed.at(named.name) > 1 || holds(named.name, {"covariance"})))
      column = {cells[i], cells[i], "", UnitFrom::nowhere};
    if (column.unit.empty() && i < units.size() && bare_unit(units[i]) != not_read) column.unit = bare_unit(units[i]);
    if (!column.unit.empty() && column.from == UnitFrom::nowhere) column.from = UnitFrom::row;
    if (column.unit.empty())
      if (const auto given = options.units.find(column.name); given != options.units.end())
        column = {cells[i], column.name, given->second.text(), UnitFrom::options};
    if (column.unit.empty() && !only_brackets)
      if (const auto words = unit_in_words(cells[i])) column = {cells[i], words->name, words->unit, UnitFrom::words};
    if (column.unit.empty())
      if (const auto unit = unit_of_ros(column.name); !unit.empty())
        column = {cells[i], column.name, unit, UnitFrom::convention};
    names.push_back(column);
  }
  return names;
}

std::string_view no_signal(std::string_view name) {
  const std::string lower = lower_case(name);
  if (holds(lower, {"covariance"})) return "covariance";
  for (const std::string_view counter : {"seq", "header.seq", "header/seq"})
    if (lower == counter || lower.ends_with("." + std::string(counter)) || lower.ends_with("/" + std::string(counter)))
      return "counter";
  return "";
}

std::string likely_unit(std::string_view name, double greatest) {
  const std::string lower = lower_case(name);
  if (const auto unit = unit_at_end(lower); !unit.empty()) return std::string(unit);
  if (holds(lower, {"temp", "温度"}) || lower == "t_imu") return "degC";
  if (holds(lower, {"gyr", "omega", "ang", "rate", "陀螺", "角速度"})) return "deg/s";
  if (holds(lower, {"acc", "beschl", "加速度", "accel"})) return greatest > 3.0 ? "m/s^2" : "g";
  if (holds(lower, {"volt", "spannung", "电压"})) return "V";
  if (holds(lower, {"puls", "count", "脉冲"})) return "pulse";
  return "1";
}

bool names_segments(std::string_view name) {
  const std::string lower = lower_case(name);
  for (const std::string_view known :
       {"part", "label", "segment", "section", "position", "lage", "pose", "step", "phase", "marker", "位置", "标签"})
    if (lower == known) return true;
  return false;
}

}  // namespace tumble::csv
