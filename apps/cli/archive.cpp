#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <map>
#include <memory>

#include "archive_actions.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::cli {
namespace {

using Action = std::function<int(const ArchiveArguments&, const Terminal&)>;

const std::map<std::string, Action>& actions() {
  static const std::map<std::string, Action> all{
      {"init", archive_init},           {"ingest", archive_ingest},   {"list", archive_list},
      {"show", archive_show},           {"history", archive_history}, {"chart", archive_chart},
      {"summary", archive_summary},     {"due", archive_due},         {"verify", archive_verify},
      {"recompute", archive_recompute}, {"note", archive_note},       {"withdraw", archive_withdraw},
      {"export", archive_export},       {"import", archive_import}};
  return all;
}

std::vector<std::string> action_names() {
  std::vector<std::string> words;
  for (const auto& [word, function] : actions()) words.push_back(word);
  return words;
}

int run(const ArchiveArguments& arguments, const Terminal& terminal) {
  const auto action = actions().find(arguments.action);
  if (action != actions().end()) return action->second(arguments, terminal);
  const auto words = action_names();
  throw Error(Error::Kind::bad_input, say("archive {}: one of {} is expected{}", Name{arguments.action},
                                          fmt::join(words, ", "), did_you_mean(arguments.action, words)));
}

Argument action_of(ArchiveArguments& arguments) {
  return {.name = "ACTION",
          .value = &arguments.action,
          .description = fmt::format("one of {}", fmt::join(action_names(), ", ")),
          .required = true,
          .actions = action_names()};
}

/// What is looked at, and how.
std::vector<Argument> view_of(ArchiveArguments& arguments) {
  return {
      {.name = "--model", .value = &arguments.model, .description = "units of this model only", .type = "MODEL"},
      {.name = "--parameter",
       .value = &arguments.parameter,
       .description = "history: how this parameter has changed",
       .type = "NAME"},
      {.name = "--min", .value = &arguments.minimum, .description = "lower limit of the parameter", .type = "VALUE"},
      {.name = "--max", .value = &arguments.maximum, .description = "upper limit of the parameter", .type = "VALUE"},
      {.name = "--baseline",
       .value = &arguments.baseline,
       .description = "chart: so many first points say what is expected\n(default: 30, or half of fewer than 60)",
       .type = "NUMBER"},
      {"--every-day", &arguments.every_day, "chart of all units: a point for each day, not one for each unit"},
      {.name = "--kind",
       .value = &arguments.kind,
       .description = fmt::format("note: one of {}", fmt::join(note_kinds(), ", ")),
       .type = "KIND"},
      {.name = "--text", .value = &arguments.text, .description = "note: what happened", .type = "TEXT"},
      {.name = "--within",
       .value = &arguments.within,
       .description = "due: what ends so soon (default: 30 day)",
       .type = "TIME"},
      {.name = "--figure",
       .value = &arguments.figure,
       .description = "history, chart, summary: drawing to write (.svg);\nseveral give FIGURE-1.svg, FIGURE-2.svg, ...",
       .type = "FIGURE"},
      {"--json", &arguments.json, "print JSON instead of tables"},
      {"-o,--output", &arguments.output, "show, export, verify: file to write"}};
}

std::vector<Argument> arguments_of(ArchiveArguments& arguments) {
  std::vector<Argument> all{
      action_of(arguments),
      {"WHAT", &arguments.what,
       "ingest: files and folders of runs; show: RESULT, FILE or RUN; history, export: SERIAL or MODEL/SERIAL; chart, "
       "summary: PARAMETER; recompute, withdraw: RESULT; note: unit, instrument or model; import: FILE"},
      archive_argument(arguments.archive),
      by_argument(arguments.archive),
      {.name = "--reason", .value = &arguments.archive.why, .description = "why it is done", .type = "TEXT"},
      {.name = "--replaces",
       .value = &arguments.replaces,
       .description = "ingest: the result that the new one corrects",
       .type = "RESULT"},
      {.name = "--unit",
       .value = &arguments.unit,
       .description = "ingest: the unit, where the files do not say it;\nchart: the unit whose results are charted",
       .type = "MODEL/SERIAL"},
      {.name = "--ended",
       .value = &arguments.date,
       .description = "ingest: when the test ended, where recordings do not say it;\nnote: when it happened: "
                      "2026-11-20T09:00:00Z",
       .type = "TIME"},
      {.name = "--lab",
       .value = &arguments.lab,
       .description = "ingest: equipment of a laboratory file",
       .type = "LAB"},
      {.name = "--files",
       .value = &arguments.files,
       .description = "init: folder of the files, or `database`; required on a server",
       .type = "FOLDER"}};
  const auto view = view_of(arguments);
  all.insert(all.end(), view.begin(), view.end());
  return all;
}

}  // namespace

const std::string& only_word(const ArchiveArguments& arguments, const std::string& name) {
  if (arguments.what.size() != 1)
    throw Error(Error::Kind::bad_input,
                say("archive {0}: one {1} is expected: tumble archive {0} {1}", Name{arguments.action}, Name{name}));
  return arguments.what.front();
}

void no_words(const ArchiveArguments& arguments) {
  if (!arguments.what.empty())
    throw Error(Error::Kind::bad_input,
                say("archive {}: '{}' is one word too many", Name{arguments.action}, arguments.what.front()));
}

Verb archive_verb() {
  auto arguments = std::make_shared<ArchiveArguments>();
  return {"archive", "Keep results, recordings and certificates of units, and look at their history",
          arguments_of(*arguments),
          "Examples:\n"
          "  tumble archive init --archive lab.db\n"
          "  tumble archive ingest result.json data.h5 plan.toml --archive lab.db --by \"Li Wei\"\n"
          "  tumble archive history 0173 --archive lab.db\n"
          "  tumble archive history 0173 --parameter bias --max \"0.5 deg/h\" --figure bias.svg --archive lab.db\n"
          "  tumble archive chart bias --model fibre_optic_gyro --figure chart.svg --archive lab.db\n"
          "  tumble archive show 3f2a91 --archive lab.db\n"
          "  tumble archive export 0173 -o unit-0173.db --archive lab.db\n"
          "  tumble archive verify --archive postgresql://lab@server/archive\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
