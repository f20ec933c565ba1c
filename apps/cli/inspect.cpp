#include "inspect.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/core/json_text.hpp"
#include "tumble/language/section_words.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;
using tumble::ChannelSummary;
using tumble::Inspection;

/// In the unit, as the shortest decimal that converts back: 20.04 degC, not 20.04000000000002.
Json number(double value_si, const Unit& unit) {
  return std::isfinite(value_si) ? Json(as_number<double>(format_in(value_si, unit)).value_or(NAN)) : Json();
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

std::vector<TextColumn> columns(const std::vector<ChannelSummary>& channels, const SectionWords& words) {
  using Align = TextColumn::Align;
  std::vector<TextColumn> table{{words("channel"), "", {}, Align::left},
                                {words("unit"), "", {}, Align::left},
                                {words("kind"), "", {}, Align::left},
                                {words("samples"), "", {}},
                                {words("missing"), "", {}},
                                {words("rate"), "Hz", {}},
                                {words("minimum"), "", {}},
                                {words("mean"), "", {}},
                                {words("maximum"), "", {}},
                                {words("spread"), "", {}}};
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
std::string marks_text(const std::vector<Mark>& marks, const SectionWords& words) {
  std::string text;
  int run = 0;
  for (const auto& mark : marks) {
    if (mark.run == run)
      text += words("comma");
    else
      text += (run ? "\n" : "\n" + words("runs_list") + "\n") + words.with("run_from", mark.run, mark.begin);
    text += mark.label.empty() ? words("no_label") : mark.label;
    run = mark.run;
  }
  return text.empty() ? "" : text + "\n";
}

/// "  separator     semicolon"
std::string recognised_text(const std::vector<Recognised>& entries, const SectionWords& words, std::size_t width) {
  std::string text = entries.empty() ? "" : "\n" + words("recognised_list") + "\n";
  for (const auto& [what, how] : entries) text += wrapped(fmt::format("  {:<14}", what), how, width);
  return text;
}

std::string text(const Inspection& inspection, const Terminal& terminal) {
  const SectionWords words{terminal.language};
  const auto& header = inspection.header;
  std::string out = header.origin.file + (header.instrument.empty() ? "" : words("colon") + header.instrument) + "\n";
  if (!inspection.channels.empty()) {
    const auto& one = inspection.channels.front();
    const auto count = inspection.channels.size();
    out += words.with(count == 1 ? "channel_from_to" : "channels_from_to", count, shown(one.last - one.first, 9),
                      shown(one.first, 9), shown(one.last, 9)) +
           "\n";
  }
  out += "\n" + text_table(columns(inspection.channels, words), terminal.width) + marks_text(header.marks, words);
  out += recognised_text(header.recognised, words, terminal.width);
  if (!header.meta.empty()) out += "\n" + words("meta_list") + "\n";
  for (const auto& [key, value] : header.meta) out += fmt::format("  {}: {}\n", key, value);
  return out + "\n" + to_text(inspection.findings, terminal.width, terminal.language);
}

struct InspectArguments {
  std::string recording;
  std::vector<std::string> sets, topics;
  bool json = false;
};

int run(const InspectArguments& arguments, const Terminal& terminal) {
  const auto options = tumble::read_options(parse_sets(arguments.sets, arguments.topics));
  Inspection inspection;
  {
    ProgressLine line(terminal);
    inspection = tumble::inspect(readable(arguments.recording), options, line.progress());
    if (arguments.recording == "-") inspection.header.origin.file = "standard input";
  }
  print(arguments.json ? inspection_json(inspection) : text(inspection, terminal));
  return 0;
}

}  // namespace

std::string inspection_json(const Inspection& inspection) { return json_text(json(inspection), 2) + "\n"; }

Verb inspect_verb() {
  auto arguments = std::make_shared<InspectArguments>();
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
