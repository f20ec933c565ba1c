#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "archive_options.hpp"
#include "archive_views.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/unit.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string action;
  std::vector<std::string> what;
  ArchiveOptions archive;
  std::string files, unit, model, replaces, within = "30 days", output, date;
  bool json = false;
};

using Action = std::function<int(const Arguments&, const Terminal&)>;

/// The only word that an action takes.
const std::string& single(const Arguments& arguments, const std::string& name) {
  if (arguments.what.size() != 1)
    throw Error(Error::Kind::bad_input,
                fmt::format("archive {0}: one {1} is expected: tumble archive {0} {1}", arguments.action, name));
  return arguments.what.front();
}

void no_words(const Arguments& arguments) {
  if (!arguments.what.empty())
    throw Error(Error::Kind::bad_input,
                fmt::format("archive {}: '{}' is one word too many", arguments.action, arguments.what.front()));
}

int init(const Arguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const std::string address = archive_address(arguments.archive);
  if (address.empty()) open_archive(arguments.archive);  // says what is missing
  make_archive(address, arguments.files, act_of(arguments.archive));
  const Archive archive(address);
  note(terminal, fmt::format("made the archive; its files will lie in {}", archive.folder()));
  return 0;
}

/// What stands in these files: results by their extension, all others as files of the results.
Deposit deposit_of(const Arguments& arguments, const Archive& archive) {
  Deposit deposit;
  std::vector<std::string> problems;
  const UnitName unit = unit_name(arguments.unit);
  for (const auto& path : arguments.what) {
    if (fs::is_directory(path))
      problems.push_back(path + ": is a folder; give the files in it");
    else if (path.ends_with(".json"))
      deposit.results.push_back({.json = read_text_file(path), .file = path, .unit = unit, .ended = arguments.date});
    else if (path.ends_with(".html") || path.ends_with(".xml"))
      problems.push_back(path + ": a certificate is archived where it is made: tumble certificate --archive");
    else
      deposit.files.push_back({.path = path, .name = fs::path(path).filename().string(), .unit = unit});
  }
  if (!arguments.replaces.empty()) {
    if (deposit.results.size() != 1)
      problems.emplace_back("--replaces: one result is expected with it, which replaces the other one");
    else
      deposit.results.front().corrects = find_result(archive, arguments.replaces);
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return deposit;
}

int ingest(const Arguments& arguments, const Terminal& terminal) {
  if (arguments.what.empty())
    throw Error(Error::Kind::bad_input, "archive ingest: files are expected: results (.json), recordings, plans");
  Archive archive = open_archive(arguments.archive);
  note_deposited(terminal, put_in(archive, deposit_of(arguments, archive), act_of(arguments.archive)));
  return 0;
}

int list(const Arguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const auto units = archived_units(open_archive(arguments.archive), arguments.model);
  print(arguments.json ? units_json(units) : units_text(units, terminal.width));
  return 0;
}

int show(const Arguments& arguments, const Terminal& terminal) {
  const std::string& digits = single(arguments, "RESULT");
  const Archive archive = open_archive(arguments.archive);
  const std::string sha256 = find_result(archive, digits), text = result_text(archive, sha256);
  if (!arguments.output.empty())
    write_output(terminal, arguments.output, text);
  else
    print(arguments.json ? text : to_text(estimate_from_json(text, "result " + digits), terminal.width));
  return 0;
}

int history(const Arguments& arguments, const Terminal& terminal) {
  const std::string& words = single(arguments, "SERIAL");
  const Archive archive = open_archive(arguments.archive);
  const auto record = unit_record(archive, find_unit(archive, words));
  print(arguments.json ? record_json(record) : record_text(record, terminal.width));
  return 0;
}

int due(const Arguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const double within = parse_si(arguments.within, Unit::parse("s"));
  const auto calibrations = due_calibrations(open_archive(arguments.archive), utc_day(within));
  print(arguments.json ? due_json(calibrations) : due_text(calibrations, utc_day(0.0), terminal.width));
  return 0;
}

int verify(const Arguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const Archive archive = open_archive(arguments.archive);
  ArchiveCheck check;
  {
    ProgressLine line(terminal);
    check = verify_archive(archive, line.progress());
  }
  print(check_text(check));
  return check.problems.empty() ? 0 : 3;
}

const std::map<std::string, Action>& actions() {
  static const std::map<std::string, Action> all{{"init", init},    {"ingest", ingest},   {"list", list},
                                                 {"show", show},    {"history", history}, {"due", due},
                                                 {"verify", verify}};
  return all;
}

int run(const Arguments& arguments, const Terminal& terminal) {
  const auto action = actions().find(arguments.action);
  if (action != actions().end()) return action->second(arguments, terminal);
  std::vector<std::string> words;
  for (const auto& [word, function] : actions()) words.push_back(word);
  throw Error(Error::Kind::bad_input, fmt::format("archive {}: one of {} is expected{}", arguments.action,
                                                  fmt::join(words, ", "), did_you_mean(arguments.action, words)));
}

std::vector<Argument> arguments_of(Arguments& arguments) {
  return {
      {"ACTION", &arguments.action, "init, ingest, list, show, history, due or verify", true},
      {"WHAT", &arguments.what, "files for ingest, RESULT for show, SERIAL or MODEL/SERIAL for history"},
      archive_argument(arguments.archive),
      by_argument(arguments.archive),
      {.name = "--reason", .value = &arguments.archive.why, .description = "why a result is replaced", .type = "TEXT"},
      {.name = "--replaces",
       .value = &arguments.replaces,
       .description = "ingest: the result that the new one corrects",
       .type = "RESULT"},
      {.name = "--unit",
       .value = &arguments.unit,
       .description = "ingest: the unit, where the files do not say it",
       .type = "MODEL/SERIAL"},
      {.name = "--ended",
       .value = &arguments.date,
       .description = "ingest: when the test ended, where recordings do not say it:\n2026-11-20T09:00:00Z",
       .type = "TIME"},
      {.name = "--files",
       .value = &arguments.files,
       .description = "init: folder of the files; required on a server",
       .type = "FOLDER"},
      {.name = "--model", .value = &arguments.model, .description = "list: units of this model only", .type = "MODEL"},
      {.name = "--within",
       .value = &arguments.within,
       .description = "due: calibrations that end so soon (default: 30 days)",
       .type = "TIME"},
      {"--json", &arguments.json, "print JSON instead of tables"},
      {"-o,--output", &arguments.output, "show: file to write the result to (.json)"}};
}

}  // namespace

Verb archive_verb() {
  auto arguments = std::make_shared<Arguments>();
  return {"archive", "Keep results, recordings and certificates of units, and look at their history",
          arguments_of(*arguments),
          "Examples:\n"
          "  tumble archive init --archive lab.db\n"
          "  tumble archive ingest result.json data.h5 plan.toml --archive lab.db --by \"Li Wei\"\n"
          "  tumble archive history 0173 --archive lab.db\n"
          "  tumble archive show 3f2a91 --archive lab.db\n"
          "  tumble archive verify --archive postgresql://lab@server/archive\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
