#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "tumble/report/report.hpp"
#include "tumble/tasks/fleet_summary.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "tumble/units/text_parts.hpp"
#include "verbs.hpp"

extern char** environ;

namespace tumble::cli {
namespace {

struct FleetArguments {
  std::string action;
  std::vector<std::string> what, sets, parameters, least, most;
  std::string output, executor, scheduler, workers, retries, patience, serial, timeout, archive, by;
  bool retry_errors = false, json = false;
};

/// The Python that has the package: TUMBLE_PYTHON, else python3 of the path.
std::string python() {
  const char* const named = std::getenv("TUMBLE_PYTHON");
  return named && *named ? named : "python3";
}

bool has_package(const std::string& program) {
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&quiet, stream, "/dev/null", O_WRONLY, 0);
  std::string name = program, option = "-c", code = "import tumble.fleet, fsspec, pyarrow";
  char* const words[] = {name.data(), option.data(), code.data(), nullptr};
  pid_t child = 0;
  const bool begun = posix_spawnp(&child, name.c_str(), &quiet, nullptr, words, environ) == 0;
  posix_spawn_file_actions_destroy(&quiet);
  int status = 1;
  return begun && waitpid(child, &status, 0) == child && status == 0;
}

/// The same words for python3 -m tumble.fleet, which takes the place of this process.
[[noreturn]] void hand_over(const FleetArguments& arguments) {
  const std::string program = python();
  if (!has_package(program))
    throw Error(Error::Kind::unsupported,
                say("fleet {}: this is done by the Python package, which {} does not have: pip install "
                    "'tumble[fleet]'; the environment variable TUMBLE_PYTHON names the Python to use",
                    Name{arguments.action}, Name{program}));
  std::vector<std::string> words{program, "-m", "tumble.fleet", arguments.action};
  const auto option = [&](const char* name, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {name, value});
  };
  option("--output", arguments.output);
  option("--executor", arguments.executor);
  option("--scheduler", arguments.scheduler);
  option("--workers", arguments.workers);
  option("--retries", arguments.retries);
  option("--patience", arguments.patience);
  option("--serial", arguments.serial);
  option("--timeout", arguments.timeout);
  option("--archive", arguments.archive);
  option("--by", arguments.by);
  for (const auto& set : arguments.sets) option("--set", set);
  if (arguments.retry_errors) words.emplace_back("--retry-errors");
  words.emplace_back("--");
  words.insert(words.end(), arguments.what.begin(), arguments.what.end());
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execvp(pointers.front(), pointers.data());
  throw Error(Error::Kind::unsupported, say("fleet {}: {} cannot be run", Name{arguments.action}, Name{program}));
}

/// NAME=VALUE of --min and --max as settings NAME.min and NAME.max.
Sets limits_of(const FleetArguments& arguments) {
  Sets sets;
  const auto add = [&](const std::vector<std::string>& texts, const char* option, const char* end) {
    for (const auto& text : texts) {
      const auto named = key_and_value(text);
      if (!named || named->first.empty())
        throw Error(Error::Kind::bad_input, say("{} {}: write {} PARAMETER=VALUE", option, Name{text}, option));
      sets.emplace_back(named->first + "." + end, named->second);
    }
  };
  add(arguments.least, "--min", "min");
  add(arguments.most, "--max", "max");
  return sets;
}

int summary(const FleetArguments& arguments, const Terminal& terminal) {
  if (arguments.what.size() != 1)
    throw Error(Error::Kind::bad_input, "fleet summary: one folder is expected: tumble fleet summary FOLDER");
  if (!arguments.output.empty() && arguments.output != "-")
    check_output("-o", arguments.output, arguments.what, {".json", ".html", ".htm"});
  const Estimate estimate = summarise_fleet(arguments.what.front(), arguments.parameters, limits_of(arguments));
  if (std::filesystem::path(arguments.output).extension() == ".json")
    write_output(terminal, arguments.output, to_json(estimate));
  else if (!arguments.output.empty() && arguments.output != "-")
    write_output(terminal, arguments.output, to_html(estimate, {.language = terminal.language}));
  print(arguments.json ? to_json(estimate) : to_text(estimate, terminal.width, terminal.language));
  return 0;
}

const std::vector<std::string>& fleet_actions() {
  static const std::vector<std::string> all{"run", "record", "status", "compact", "summary"};
  return all;
}

int run(const FleetArguments& arguments, const Terminal& terminal) {
  if (arguments.action == "summary") return summary(arguments, terminal);
  if (std::ranges::find(fleet_actions(), arguments.action) == fleet_actions().end())
    throw Error(Error::Kind::bad_input,
                say("fleet {}: one of {} is expected{}", Name{arguments.action}, fmt::join(fleet_actions(), ", "),
                    did_you_mean(arguments.action, fleet_actions())));
  hand_over(arguments);
}

/// How the work is spread.
std::vector<Argument> workers_of(FleetArguments& arguments) {
  return {{.name = "--executor",
           .value = &arguments.executor,
           .description = "run, record: where the work is done (default: processes)",
           .words = {"processes", "serial", "dask"}},
          {.name = "--scheduler",
           .value = &arguments.scheduler,
           .description = "run, record: a Dask cluster that is there: tcp://host:8786",
           .type = "ADDRESS"},
          {.name = "--workers",
           .value = &arguments.workers,
           .description = "run, record: number of processes (default: one for each\nprocessor)",
           .type = "NUMBER"},
          {.name = "--retries",
           .value = &arguments.retries,
           .description = "run, record: how often a task is tried again whose worker\nended (default: 2)",
           .type = "NUMBER"},
          {.name = "--patience",
           .value = &arguments.patience,
           .description = "run, record: how long a run waits while a cluster has no\nworker, or no scheduler that "
                          "answers (default: 600)",
           .type = "SECONDS"},
          {.name = "--timeout",
           .value = &arguments.timeout,
           .description = "run: seconds after which a worker is ended",
           .type = "SECONDS"}};
}

/// What is done with each recording.
std::vector<Argument> reduction_of(FleetArguments& arguments) {
  return {{"--retry-errors", &arguments.retry_errors, "run: reduce recordings again whose row is an error"},
          {.name = "--serial",
           .value = &arguments.serial,
           .description = "run: regular expression that finds the serial number in a\nname (default: the file's name)",
           .type = "PATTERN"},
          {.name = "--archive",
           .value = &arguments.archive,
           .description = "run: archive that takes the results",
           .type = "ARCHIVE"},
          {.name = "--by", .value = &arguments.by, .description = "run: who archives them", .type = "NAME"},
          {.name = "--set",
           .value = &arguments.sets,
           .description = "run, record: replaces a value of the plan; repeatable",
           .type = "KEY=VALUE"}};
}

/// What a summary holds.
std::vector<Argument> summary_of(FleetArguments& arguments) {
  return {{.name = "--parameter",
           .value = &arguments.parameters,
           .description = "summary: this parameter only; repeatable",
           .type = "NAME"},
          {.name = "--min",
           .value = &arguments.least,
           .description = "summary: lower limit, for capability and risk; repeatable",
           .type = "NAME=VALUE"},
          {.name = "--max",
           .value = &arguments.most,
           .description = "summary: upper limit; repeatable",
           .type = "NAME=VALUE"},
          {"--json", &arguments.json, "summary: print JSON instead of text"}};
}

std::vector<Argument> arguments_of(FleetArguments& arguments) {
  std::vector<Argument> all{
      {.name = "ACTION",
       .value = &arguments.action,
       .description = "run, record, status, compact or summary",
       .required = true,
       .actions = fleet_actions()},
      {"WHAT", &arguments.what,
       "run: PLAN and recordings, patterns or folders;\nrecord: PLAN and the files of one record;\nstatus, compact, "
       "summary: FOLDER of the fleet"},
      {.name = "-o,--output",
       .value = &arguments.output,
       .description = "run, record: folder of the fleet;\nsummary: file to write (.json, .html)",
       .type = "FOLDER|FILE"}};
  for (const auto& some : {workers_of(arguments), reduction_of(arguments), summary_of(arguments)})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace

Verb fleet_verb() {
  auto arguments = std::make_shared<FleetArguments>();
  return {"fleet", "Reduce recordings of many units, and summarise them", arguments_of(*arguments),
          "Examples:\n"
          "  tumble fleet run plan.toml 'data/*.h5' -o fleet\n"
          "  tumble fleet status fleet\n"
          "  tumble fleet summary fleet --min \"x.bias=-1 mg\" --max \"x.bias=1 mg\" -o fleet.html\n"
          "  tumble fleet record allan_noise 'year/*.h5' -o year\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
