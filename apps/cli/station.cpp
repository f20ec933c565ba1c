#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/core/said.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/station/link_wires.hpp"
#include "tumble/station/talk_to.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string what, station, output;
};

std::string said(const ControllerReply& reply) {
  if (!reply.problem.empty()) return "no: " + reply.problem;
  if (reply.refused) return "refused: " + reply.text;
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [name, word] : reply.words) add(name + " " + word);
  for (const auto& [name, value] : reply.values) add(fmt::format("{} {:.6g} (SI)", name, value));
  return text.empty() ? "answered" : text;
}

int run(const Arguments& arguments, const Terminal& terminal) {
  if (arguments.what != "check")
    throw Error(Error::Kind::bad_input,
                "station " + arguments.what + ": 'check' is expected: tumble station check FILE");
  Station station = load_station(arguments.station);
  const StationParts parts = parts_of(station);
  const double begin = wall_time();
  LinkWires links(station, [begin] { return wall_time() - begin; });
  using Align = TextColumn::Align;
  TextColumn devices{"device", "", {}, Align::left}, verbs{"asked", "", {}, Align::left},
      answers{"answer", "", {}, Align::left}, times{"ms", "", {}};
  bool good = true;
  for (const DeviceAnswer& answer : talk_to(station, parts, links.wires())) {
    devices.cells.push_back(answer.device);
    verbs.cells.push_back(answer.verb);
    answers.cells.push_back(said(answer.reply));
    times.cells.push_back(fmt::format("{:.1f}", 1e3 * answer.after));
    good = good && answer.reply.problem.empty();
  }
  const auto counts = listen_to(station, parts, links.wires(), 1.0);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (station.instruments[i].frames.empty()) continue;
    devices.cells.push_back(station.instruments[i].slot);
    verbs.cells.emplace_back("stream, 1 s");
    const bool silent = counts[i].good == 0 && counts[i].damaged.count == 0 && counts[i].skipped_bytes == 0;
    const bool may_be_off = silent && station.power.device;  // a run switches it on
    answers.cells.push_back(may_be_off ? fmt::format("silent; {} switches it on when a run begins",
                                                     station.devices[*station.power.device].name)
                                       : fmt::format("{} frames, {} damaged, {} bytes of nothing known", counts[i].good,
                                                     counts[i].damaged.count, counts[i].skipped_bytes));
    times.cells.emplace_back();
    good = good && (counts[i].good > 0 || may_be_off);
  }
  if (!arguments.output.empty()) {
    Json rows = Json::array();
    for (std::size_t i = 0; i < devices.cells.size(); ++i)
      rows.push_back({{"device", devices.cells[i]},
                      {"asked", verbs.cells[i]},
                      {"answer", answers.cells[i]},
                      {"milliseconds", times.cells[i]}});
    write_output(terminal, arguments.output, Json{{"good", good}, {"rows", rows}}.dump(2) + "\n");
    if (!good) complain(terminal, "some devices do not answer; nothing was moved");
    return good ? 0 : 3;
  }
  for (TextColumn* column : {&verbs, &answers})
    for (std::string& cell : column->cells) cell = said_in(terminal.language, cell);
  print(table_said(terminal, {devices, verbs, answers, times}));
  print_said(terminal,
             good ? "\nall devices answer; nothing was moved\n" : "\nsome devices do not answer; nothing was moved\n");
  return good ? 0 : 3;
}

}  // namespace

Verb station_verb() {
  auto arguments = std::make_shared<Arguments>();
  return {
      "station",
      "Speak to all devices of a station, and move none",
      {{"WHAT", &arguments->what, "check", true},
       {"STATION", &arguments->station, "station file (.toml)", true},
       {"-o,--output", &arguments->output, "write the answers as JSON in place of the table; - is standard output"}},
      "Example:\n"
      "  tumble station check bench.toml\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
