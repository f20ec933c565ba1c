#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "archive_options.hpp"
#include "prior_option.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"
#include "unit_option.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct IdentifyArguments {
  std::string what, output, unit;
  std::vector<std::string> recordings, sets, topics;
  bool json = false, strict = false;
  std::uint64_t memory = 2'000'000'000;
  ArchiveOptions archive;
};

bool is_method(const std::string& word) {
  return std::ranges::any_of(method_catalogue(), [&](const Method* method) { return word == method->name; });
}

/// A recording first and then the method, or the plan.
void refuse_another_order(const std::string& what, const std::vector<std::string>& recordings) {
  if (std::filesystem::path(what).extension() == ".toml" || is_method(what)) return;
  for (const auto& word : recordings)
    if (is_method(word) || std::filesystem::path(word).extension() == ".toml")
      throw Error(Error::Kind::bad_input, say("the plan or the method comes first, then the recordings: tumble "
                                              "identify {} {}",
                                              Name{word}, Name{what}));
}

/// A plan is a file, a method a word, also where a folder has its name.
Plan plan_of(const std::string& what, const tumble::Sets& sets) {
  const std::filesystem::path path(what);
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  const bool is_file = exists(status) && !is_directory(status);
  if (path.extension() == ".toml" || path.has_parent_path() || is_file) return tumble::load_plan(what, sets);
  return tumble::plan_for_method(what, sets);
}

std::vector<std::string> inputs_of(const IdentifyArguments& arguments, const Plan& plan) {
  auto inputs = arguments.recordings;
  for (const auto& entry : plan.recordings) inputs.push_back(entry.file);
  if (!plan.file.empty()) inputs.push_back(plan.file);
  return inputs;
}

/// "-" among the recordings is read into memory, whole.
Estimate identify(Plan plan, const IdentifyArguments& arguments, const Progress& progress) {
  auto files = arguments.recordings;
  const auto streams = std::erase(files, "-");
  if (streams > 1) throw Error(Error::Kind::bad_input, "-: standard input can be read only once");
  if (streams == 0) return tumble::identify(plan, files, arguments.memory, progress);
  auto recording = read_standard_input(plan.reading, progress);
  plan.reading = {};  // it says nothing of other files
  return tumble::identify(gather(std::move(plan), files, {std::move(recording)}, progress), progress);
}

void show(const Estimate& estimate, const IdentifyArguments& arguments, const Terminal& terminal) {
  if (!arguments.output.empty()) write_output(terminal, arguments.output, to_json(estimate));
  if (arguments.output == standard_output) return;
  if (arguments.json)
    print(to_json(estimate));
  else if (arguments.output.empty() || !terminal.quiet)
    print(to_text(estimate, terminal.width, terminal.language));
}

/// The result, and the files that it was made from.
Deposit deposit_of(const Estimate& estimate, const IdentifyArguments& arguments, const Plan& plan) {
  Deposit deposit;
  const std::string name =
      arguments.output.empty() || arguments.output == standard_output ? std::string("result") : arguments.output;
  deposit.results.push_back({.json = to_json(estimate), .file = name});
  const auto add = [&](const std::string& path) {
    if (!path.empty() && path != "-")
      deposit.files.push_back({.path = path, .name = std::filesystem::path(path).filename().string()});
  };
  for (const auto& path : inputs_of(arguments, plan)) add(path);
  for (const auto& entry : plan.recordings)
    if (entry.plan) add(entry.plan->file);
  add(plan.calibration.file);
  return deposit;
}

int run(const IdentifyArguments& arguments, const Terminal& terminal) {
  refuse_another_order(arguments.what, arguments.recordings);
  auto sets = parse_sets(arguments.sets, arguments.topics);
  for (auto& set : sets_of_unit(arguments.unit)) sets.push_back(std::move(set));
  auto plan = plan_of(arguments.what, sets);
  read_prior_from(arguments.archive, plan);
  if (!arguments.output.empty()) check_output("-o", arguments.output, inputs_of(arguments, plan), {".json"});
  auto archive = optional_archive(arguments.archive);
  Estimate estimate;
  {
    ProgressLine line(terminal);
    estimate = identify(plan, arguments, line.progress());
  }
  show(estimate, arguments, terminal);
  if (archive && unit_is_known({estimate.instrument_model, estimate.instrument_serial}, arguments.archive, terminal))
    note_deposited(terminal, put_in(*archive, deposit_of(estimate, arguments, plan), act_of(arguments.archive)));
  const auto not_kept = [&](const Verdict& verdict) {  // what cannot be judged is not kept either
    return verdict.outcome == Verdict::Outcome::fail ||
           (verdict.outcome == Verdict::Outcome::undecided && !find_parameter(estimate, verdict.parameter));
  };
  return arguments.strict && std::ranges::any_of(estimate.verdicts, not_kept) ? 1 : 0;
}

}  // namespace

Verb identify_verb() {
  auto arguments = std::make_shared<IdentifyArguments>();
  return {
      "identify",
      "Identify parameters with their uncertainty, from a plan and recordings",
      {{"PLAN|METHOD", &arguments->what, "plan file (.toml), or the name of a method that needs none", true},
       {"RECORDING", &arguments->recordings, "recordings, in addition to those of the plan; - reads standard input"},
       {"-o,--output", &arguments->output,
        "result to write (.json); the table is printed as well; - writes to standard output"},
       {"--json", &arguments->json, "print the result as JSON instead of a table"},
       {"--strict", &arguments->strict, "exit status 1 if a limit of the plan fails or cannot be decided"},
       {.name = "--memory-limit",
        .value = &arguments->memory,
        .description = "a recording with more bytes of samples is processed\nin blocks, if the method supports it",
        .type = "SIZE",
        .bytes = "2 GB"},
       {"--unit", &arguments->unit,
        "serial number of the unit, as SERIAL or SLOT=SERIAL;\nanother one than that of the recording or result is an "
        "error",
        false, "UNIT"},
       archive_argument(arguments->archive),
       by_argument(arguments->archive),
       topic_argument(arguments->topics),
       reading_sets(arguments->sets,
                    "a setting of the method (see `tumble list methods NAME`), or\n"
                    "channels.ROLE=COLUMN, or information that a file")},
      "Examples:\n"
      "  tumble identify allan_noise data.csv --set rate=100\n"
      "  tumble identify static_bias data.csv --set channels.signal=gyro.x --set unit.gyro.x=deg/h\n"
      "  tumble identify fog.toml fog.h5 -o fog.json\n"
      "  tumble identify allan_noise long.h5 --memory-limit \"500 MB\"\n"
      "  gunzip -c day.csv.gz | tumble identify allan_noise -\n"
      "  tumble identify acceptance.toml --strict --json | jq .verdicts\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
