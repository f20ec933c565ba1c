#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <optional>
#include <string_view>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/compensation_report.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct CompensateArguments {
  std::string result, recording, output, plan, save;
  std::vector<std::string> sets, topics;
};

/// Before a long recording is read.
void require_error_model(const Estimate& estimate, const std::string& file) {
  if (!estimate.models.empty()) return;
  std::vector<std::string_view> able;
  for (const Method* method : method_catalogue())
    if (method->compensates) able.push_back(method->name);
  throw Error(Error::Kind::unsupported,
              say("{}: {} identifies no error model that could be subtracted from a recording; these methods do: {}",
                  file, estimate.method, fmt::join(able, ", ")));
}

int run(const CompensateArguments& arguments, const Terminal& terminal) {
  check_recording_output(arguments.output, {arguments.result, arguments.recording});
  if (!arguments.save.empty())
    check_output("--save", arguments.save, {arguments.result, arguments.recording}, {".json"});
  const auto options = tumble::read_options(parse_sets(arguments.sets, arguments.topics));
  const auto estimate = read_result(arguments.result);
  require_error_model(estimate, arguments.result);
  std::optional<Plan> plan;
  if (!arguments.plan.empty()) plan = tumble::load_plan(arguments.plan, {});
  Estimate shown;
  {
    ProgressLine line(terminal);
    const auto recording = arguments.recording == "-" ? read_standard_input(options, line.progress())
                                                      : read_recording(arguments.recording, options, line.progress());
    const auto compensation = tumble::compensate(estimate, recording, plan ? &*plan : nullptr);
    write_recording(compensation.recording, arguments.output);
    shown = compensation_report(estimate, recording, compensation);
    shown.title = arguments.recording + " compensated";
  }
  if (!arguments.save.empty()) write_output(terminal, arguments.save, to_json(shown));
  if (arguments.output == standard_output) return 0;
  note(terminal, say("wrote {}", Name{arguments.output}));
  if (!terminal.quiet) print(to_text(shown, terminal.width, terminal.language));
  return 0;
}

}  // namespace

Verb compensate_verb() {
  auto arguments = std::make_shared<CompensateArguments>();
  return {"compensate",
          "Subtract an identified error model from a recording",
          {{"RESULT", &arguments->result, "result (.json) of identify", true},
           {"RECORDING", &arguments->recording, "recording to compensate; - reads standard input", true},
           {"-o,--output", &arguments->output, "recording to write; - writes CSV to standard output", true},
           {"--save", &arguments->save,
            "what was done, as a result (.json): channels before and after, for report and the workbench"},
           {"--plan", &arguments->plan, "plan whose rig and schedule say what was felt, where the recording does not"},
           topic_argument(arguments->topics),
           reading_sets(arguments->sets)},
          "Example:\n  tumble compensate fog.json flight.csv -o flight-compensated.csv\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
