#include "inspect.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/report/report.hpp"
#include "tumble/report/text_table.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;
using tumble::ChannelSummary;
using tumble::Inspection;

const char* word(Finding::Severity severity) {
  switch (severity) {
    case Finding::Severity::info:
      return "info";
    case Finding::Severity::warning:
      return "warning";
    case Finding::Severity::error:
      return "error";
  }
  return "";
}

/// In the unit, as the shortest decimal that converts back: 20.04 degC, not 20.04000000000002.
Json number(double value_si, const Unit& unit) {
  double value = 0.0;
  const auto text = format_in(value_si, unit);
  std::from_chars(text.data(), text.data() + text.size(), value);
  return std::isfinite(value_si) ? Json(value) : Json();
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json json(const ChannelSummary& channel) {
  const auto& unit = channel.unit;
  return {{"name", channel.name},
          {"kind", std::string(name(channel.kind))},
          {"unit", unit.text()},
          {"samples", channel.samples},
          {"missing", channel.missing},
          {"rate", number(channel.rate())},
          {"uniform", channel.uniform},
          {"first", number(channel.first)},
          {"last", number(channel.last)},
          {"minimum", number(channel.minimum, unit)},
          {"mean", number(channel.mean, unit)},
          {"maximum", number(channel.maximum, unit)},
          {"sd", number(unit.difference_from_si(channel.sd))}};
}

Json json(const Inspection& inspection) {
  const auto& header = inspection.header;
  Json channels = Json::array(), marks = Json::array();
  for (const auto& channel : inspection.channels) channels.push_back(json(channel));
  for (const auto& mark : header.marks)
    marks.push_back({{"label", mark.label}, {"begin", mark.begin}, {"run", mark.run}});
  Json result{{"file", header.origin.file},
              {"sha256", sha256_of(header.origin)},
              {"instrument", header.instrument},
              {"channels", channels},
              {"marks", marks},
              {"meta", header.meta},
              {"findings", Json::parse(to_json(inspection.findings))}};
  Json recognised = Json::array();
  for (const auto& [what, how] : header.recognised) recognised.push_back({{"what", what}, {"how", how}});
  if (!recognised.empty()) result["recognised"] = recognised;
  return result;
}

std::string shown(double value, int digits = 6) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "-";
}

std::vector<TextColumn> columns(const std::vector<ChannelSummary>& channels) {
  using Align = TextColumn::Align;
  std::vector<TextColumn> table{{"channel", "", {}, Align::left},
                                {"unit", "", {}, Align::left},
                                {"kind", "", {}, Align::left},
                                {"samples", "", {}},
                                {"missing", "", {}},
                                {"rate", "Hz", {}},
                                {"min", "", {}},
                                {"mean", "", {}},
                                {"max", "", {}},
                                {"sd", "", {}}};
  for (const auto& channel : channels) {
    const auto& unit = channel.unit;
    const std::string cells[]{channel.name,
                              unit.text(),
                              std::string(name(channel.kind)),
                              std::to_string(channel.samples),
                              std::to_string(channel.missing),
                              shown(channel.rate()),
                              shown(unit.from_si(channel.minimum)),
                              shown(unit.from_si(channel.mean)),
                              shown(unit.from_si(channel.maximum)),
                              shown(unit.difference_from_si(channel.sd), 3)};
    for (std::size_t i = 0; i < table.size(); ++i) table[i].cells.push_back(cells[i]);
  }
  return table;
}

/// "run 3, from 7200 s: static, ramp up, ramp down"
std::string marks_text(const std::vector<Mark>& marks) {
  std::string text;
  int run = 0;
  for (const auto& mark : marks) {
    text +=
        mark.run == run ? ", " : fmt::format("{}  run {}, from {} s: ", run ? "\n" : "\nruns:\n", mark.run, mark.begin);
    text += mark.label.empty() ? "(no label)" : mark.label;
    run = mark.run;
  }
  return text.empty() ? "" : text + "\n";
}

/// "  separator     semicolon"
std::string recognised_text(const std::vector<Recognised>& entries, std::size_t width) {
  std::string text = entries.empty() ? "" : "\nrecognised:\n";
  for (const auto& [what, how] : entries) text += wrapped(fmt::format("  {:<14}", what), how, width);
  return text;
}

std::string text(const Inspection& inspection, std::size_t width) {
  const auto& header = inspection.header;
  std::string out = header.origin.file + (header.instrument.empty() ? "" : ": " + header.instrument) + "\n";
  if (!inspection.channels.empty()) {
    const auto& one = inspection.channels.front();
    const auto count = inspection.channels.size();
    out += fmt::format("{} channel{}, {} s from {} s to {} s\n", count, count == 1 ? "" : "s",
                       shown(one.last - one.first, 9), shown(one.first, 9), shown(one.last, 9));
  }
  out += "\n" + text_table(columns(inspection.channels), width) + marks_text(header.marks);
  out += recognised_text(header.recognised, width);
  if (!header.meta.empty()) out += "\nmeta:\n";
  for (const auto& [key, value] : header.meta) out += fmt::format("  {}: {}\n", key, value);
  out += inspection.findings.empty() ? "\nfindings: none\n" : "\nfindings:\n";
  for (const auto& finding : inspection.findings) {
    const auto where = finding.where.empty() ? "" : " (" + finding.where + ")";
    out += wrapped(fmt::format("  {}: ", word(finding.severity)), finding.message + where, width);
  }
  return out;
}

struct Arguments {
  std::string recording;
  std::vector<std::string> sets, topics;
  bool json = false;
};

int run(const Arguments& arguments, const Terminal& terminal) {
  const auto options = tumble::read_options(parse_sets(arguments.sets, arguments.topics));
  Inspection inspection;
  {
    ProgressLine line(terminal);
    inspection = tumble::inspect(readable(arguments.recording), options, line.progress());
    if (arguments.recording == "-") inspection.header.origin.file = "standard input";
  }
  print(arguments.json ? inspection_json(inspection) : text(inspection, terminal.width));
  return 0;
}

}  // namespace

std::string inspection_json(const Inspection& inspection) {
  return json(inspection).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Verb inspect_verb() {
  auto arguments = std::make_shared<Arguments>();
  return {"inspect",
          "Show the channels of a recording, and its faults",
          {{"RECORDING", &arguments->recording, "recording to read; - reads standard input", true},
           {"--json", &arguments->json, "print JSON instead of a table"},
           topic_argument(arguments->topics),
           reading_sets(arguments->sets)},
          "Examples:\n"
          "  tumble inspect data.csv\n"
          "  tumble inspect data.csv --set rate=100 --set unit.gyro=deg/s --json\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
