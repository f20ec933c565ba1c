#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/language/said.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/station/link_wires.hpp"
#include "tumble/station/talk_to.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;

struct StationArguments {
  std::string what, station, output;
};

Sentence reply_text(const ControllerReply& reply) {
  if (!reply.problem.empty()) return say("no: {}", reply.problem);
  if (reply.refused) return say("refused: {}", reply.text);
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [name, word] : reply.words) add(name + " " + word);
  for (const auto& [name, value] : reply.values) add(fmt::format("{} {:.6g} (SI)", name, value));
  return text.empty() ? Sentence("answered") : say("{}", Name{text});
}

/// What was asked and answered, row by row.
struct Answers {
  TextColumn devices{"device", "", {}, TextColumn::Align::left}, verbs{"asked", "", {}, TextColumn::Align::left},
      answers{"answer", "", {}, TextColumn::Align::left}, times{"ms", "", {}};
  std::vector<Sentence> said;  ///< the answers, for people
  bool good = true;

  void add(const std::string& device, const std::string& verb, Sentence answer, std::string time) {
    devices.cells.push_back(device);
    verbs.cells.push_back(verb);
    answers.cells.push_back(answer.text());
    times.cells.push_back(std::move(time));
    said.push_back(std::move(answer));
  }
};

Answers answers_of(Station station) {
  const StationParts parts = parts_of(station);
  const double begin = wall_time();
  LinkWires links(station, [begin] { return wall_time() - begin; });
  Answers all;
  for (const DeviceAnswer& answer : talk_to(station, parts, links.wires())) {
    all.add(answer.device, name(answer.verb), reply_text(answer.reply), fmt::format("{:.1f}", 1e3 * answer.after));
    all.good = all.good && answer.reply.problem.empty();
  }
  const auto counts = listen_to(station, parts, links.wires(), 1.0);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (station.instruments[i].frames.empty()) continue;
    const bool silent = counts[i].good == 0 && counts[i].damaged.count == 0 && counts[i].skipped_bytes == 0;
    const bool may_be_off = silent && station.power.device;  // a run switches it on
    all.add(station.instruments[i].slot, "stream, 1 s",
            may_be_off
                ? say("silent; {} switches it on when a run begins", Name{station.devices[*station.power.device].name})
                : say("{} frames, {} damaged, {} bytes of nothing known", counts[i].good, counts[i].damaged.count,
                      counts[i].skipped_bytes),
            "");
    all.good = all.good && (counts[i].good > 0 || may_be_off);
  }
  return all;
}

std::string json_of(const Answers& all) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < all.devices.cells.size(); ++i)
    rows.push_back({{"device", all.devices.cells[i]},
                    {"asked", all.verbs.cells[i]},
                    {"answer", all.answers.cells[i]},
                    {"milliseconds", all.times.cells[i]}});
  return Json{{"good", all.good}, {"rows", rows}}.dump(2) + "\n";
}

int run(const StationArguments& arguments, const Terminal& terminal) {
  if (arguments.what != "check")
    throw Error(Error::Kind::bad_input,
                say("station {}: 'check' is expected: tumble station check FILE", Name{arguments.what}));
  if (!arguments.output.empty()) check_output("-o", arguments.output, {arguments.station}, {".json"});
  Answers all = answers_of(load_station(arguments.station));
  if (!arguments.output.empty()) {
    write_output(terminal, arguments.output, json_of(all));
    if (!all.good) complain(terminal, "some devices do not answer; nothing was moved");
    return all.good ? 0 : 3;
  }
  for (std::string& cell : all.verbs.cells) cell = in_language(terminal.language, Sentence(cell.c_str()));
  for (std::size_t i = 0; i < all.said.size(); ++i) all.answers.cells[i] = in_language(terminal.language, all.said[i]);
  print(table_said(terminal, {all.devices, all.verbs, all.answers, all.times}));
  print_said(terminal, all.good ? "\nall devices answer; nothing was moved\n"
                                : "\nsome devices do not answer; nothing was moved\n");
  return all.good ? 0 : 3;
}

}  // namespace

Verb station_verb() {
  auto arguments = std::make_shared<StationArguments>();
  return {
      "station",
      "Speak to all devices of a station, and move none",
      {{.name = "WHAT", .value = &arguments->what, .description = "check", .required = true, .actions = {"check"}},
       {"STATION", &arguments->station, "station file (.toml)", true},
       {"-o,--output", &arguments->output, "write the answers as JSON in place of the table; - is standard output"}},
      "Example:\n"
      "  tumble station check bench.toml\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
