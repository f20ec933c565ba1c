#include "tumble/tasks/plan_file/write_schedule.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "tumble/core/tables/document.hpp"
#include "tumble/units/error.hpp"

namespace tumble::plan_file {
namespace {

using Kind = Motion::Kind;

std::string quoted(double si, const Unit& unit) {
  return "\"" + format_in(si, unit) + (unit.text() == "1" ? "" : " " + unit.text()) + "\"";
}

std::string list(const std::vector<double>& values, const Unit& unit) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(quoted(value, unit));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

/// "deg/s", "(m/s^2)/s".
Unit per_second(const Unit& unit) {
  const bool is_single = unit.text().find_first_of("/*^ ") == std::string::npos;
  return Unit::parse((is_single ? unit.text() : "(" + unit.text() + ")") + "/s");
}

/// The inline table of one motion.
std::string motion_text(const Motion& motion, const Axis& axis) {
  const Unit position = Unit::parse(axis.unit);
  const Unit interval = position.offset() == 0.0 ? position : Unit::parse(name(position.dimension()));
  const Unit speed = per_second(interval), hertz = Unit::parse("Hz");
  switch (motion.kind) {
    case Kind::hold:
      return fmt::format("{{hold = {}}}", quoted(motion.value, position));
    case Kind::dwell:
      return fmt::format("{{dwell = {}}}", quoted(motion.value, position));
    case Kind::rate:
      return fmt::format("{{rate = {}}}", quoted(motion.value, speed));
    case Kind::slew:
    case Kind::ramp:
      return fmt::format("{{{} = {}, to = {}}}", motion.kind == Kind::slew ? "slew" : "ramp",
                         quoted(motion.value, speed), quoted(motion.to, position));
    case Kind::sine:
      return fmt::format("{{sine = {{amplitude = {}, frequency = {}, phase = {}}}}}",
                         quoted(motion.amplitude, interval), quoted(motion.frequency, hertz),
                         quoted(motion.phase, Unit::parse("deg")));
    case Kind::sweep:
      return fmt::format("{{sweep = {{amplitude = {}, from = {}, to = {}}}}}", quoted(motion.amplitude, interval),
                         quoted(motion.frequency, hertz), quoted(motion.to_frequency, hertz));
    case Kind::random:
      return fmt::format("{{random = {{frequency = {}, psd = {}}}}}", list(motion.psd_frequency, hertz),
                         list(motion.psd, Unit::parse("(" + interval.text() + ")^2/Hz")));
  }
  return {};
}

/// TOML basic string.
std::string escaped(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string segment_text(const Segment& segment, const std::vector<int>& runs, const std::vector<Axis>& axes) {
  std::string text = "[[schedule]]\nlabel = " + escaped(segment.label) + "\n";
  text += "duration = " + quoted(segment.duration, Unit::parse("s")) + "\n";
  if (runs.size() > 1) text += fmt::format("run = [{}]\n", fmt::join(runs, ", "));
  if (runs.size() == 1 && runs.front() != 1) text += fmt::format("run = {}\n", runs.front());
  for (const auto& axis : axes)
    if (const auto found = segment.axes.find(axis.name); found != segment.axes.end())
      text += axis.name + " = " + motion_text(found->second, axis) + "\n";
  return text + "\n";
}

/// Lines, counted from 1, in which tables begin: those of the schedule and those of all else.
struct Headers {
  std::set<std::size_t> schedule, others;
};

void collect(const toml::table& table, bool of_schedule, Headers& headers) {
  for (const auto& [key, node] : table) {
    const bool here = of_schedule || (key.str() == "schedule" && table.source().begin.line <= 1);
    const auto add = [&](const toml::table& one) {
      if (one.is_inline()) return;
      (here ? headers.schedule : headers.others).insert(one.source().begin.line);
      collect(one, here, headers);
    };
    if (const auto* child = node.as_table()) add(*child);
    if (const auto* array = node.as_array())
      for (const auto& one : *array)
        if (const auto* child = one.as_table()) add(*child);
  }
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Comments and blank lines that stand right before a header belong to it.
std::size_t with_comments_before(const std::vector<std::string>& lines, std::size_t header) {
  const auto belongs = [&](std::size_t line) {
    const auto first = lines[line - 1].find_first_not_of(" \t\r");
    return first == std::string::npos || lines[line - 1][first] == '#';
  };
  while (header > 1 && belongs(header - 1)) --header;
  return header;
}

}  // namespace

std::string schedule_text(const Schedule& schedule, const std::vector<Axis>& axes) {
  std::vector<int> runs;
  for (const auto& segment : schedule)
    if (std::ranges::find(runs, segment.run) == runs.end()) runs.push_back(segment.run);
  const auto written = [&](const Segment& segment) { return segment_text(segment, {0}, axes); };
  std::vector<std::string> of_run;
  for (const int run : runs) {
    std::string text;
    for (const auto& segment : schedule)
      if (segment.run == run) text += written(segment);
    of_run.push_back(text);
  }
  const bool alike = std::ranges::all_of(of_run, [&](const auto& text) { return text == of_run.front(); });
  std::string text;
  for (const auto& segment : schedule) {
    if (alike && segment.run != runs.front()) continue;
    text += segment_text(segment, alike ? runs : std::vector<int>{segment.run}, axes);
  }
  return text;
}

std::string with_schedule(const std::string& plan, const std::string& file, const std::string& schedule) {
  const auto lines = lines_of(plan);
  Headers headers;
  const auto document = tables::document_of(plan, file);
  if (const auto* node = document.get("schedule")) {
    const auto* array = node->as_array();
    if (!array ||
        std::ranges::any_of(*array, [](const auto& one) { return !one.is_table() || one.as_table()->is_inline(); }))
      throw Error(Error::Kind::bad_input,
                  say("{}: to be replaced the schedule must be written as [[schedule]] tables", Name{file}));
  }
  collect(document, false, headers);
  std::string text;
  bool inside = false, placed = false;
  const auto place = [&] {
    if (!placed && !text.empty() && !text.ends_with("\n\n")) text += "\n";
    if (!placed) text += schedule;
    placed = true;
  };
  std::set<std::size_t> ends;
  for (const auto line : headers.others) ends.insert(with_comments_before(lines, line));
  for (std::size_t line = 1; line <= lines.size(); ++line) {
    if (headers.schedule.contains(line))
      inside = true, place();
    else if (inside && ends.contains(line))
      inside = false;
    const bool second_blank = lines[line - 1].find_first_not_of(" \t\r") == std::string::npos && text.ends_with("\n\n");
    if (!inside && !(placed && second_blank)) text += lines[line - 1] + "\n";
  }
  place();
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace tumble::plan_file
