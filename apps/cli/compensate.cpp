#include <memory>
#include <optional>

#include "tumble/report/report.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct Arguments {
  std::string result, recording, output, plan;
  std::vector<std::string> sets;
};

int run(const Arguments& arguments, const Terminal& terminal) {
  check_recording_output(arguments.output, {arguments.result, arguments.recording});
  const auto options = tumble::read_options(parse_sets(arguments.sets));
  const auto estimate = read_result(arguments.result);
  std::optional<Plan> plan;
  if (!arguments.plan.empty()) plan = tumble::load_plan(arguments.plan, {});
  Compensation compensation;
  {
    ProgressLine line(terminal);
    compensation = tumble::compensate(estimate, read_recording(arguments.recording, options, line.progress()),
                                      plan ? &*plan : nullptr);
    write_recording(compensation.recording, arguments.output);
  }
  note(terminal, "wrote " + arguments.output);
  Estimate shown;  // no parameters: only what the method says of its work
  shown.method = estimate.method;
  shown.title = arguments.recording + " compensated";
  shown.findings = std::move(compensation.findings);
  shown.tables = std::move(compensation.tables);
  if (!terminal.quiet) print(to_text(shown));
  return 0;
}

}  // namespace

Verb add_compensate(CLI::App& program) {
  auto* app = program.add_subcommand("compensate", "Subtract an identified error model from a recording");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("RESULT", arguments->result, "result (.json) of identify")->required();
  app->add_option("RECORDING", arguments->recording, "recording to compensate")->required();
  app->add_option("-o,--output", arguments->output, "recording to write")->required();
  app->add_option("--plan", arguments->plan,
                  "plan whose rig and schedule say what was felt, where the recording does not");
  add_sets(*app, arguments->sets,
           "information that the file does not contain:\n"
           "rate=100, missing=WORD, unit.COLUMN=deg/h,\n"
           "columns=\"time[s],x[deg/s]\" for a file without a header,\n"
           "segment_column=COLUMN with labels; repeatable");
  app->footer("Example:\n  tumble compensate fog.json flight.csv -o flight-compensated.csv\n");
  return {app, [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
