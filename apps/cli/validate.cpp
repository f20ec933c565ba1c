#include "tumble/tasks/validate.hpp"

#include <cmath>
#include <memory>
#include <thread>

#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

struct ValidateArguments {
  std::string plan, departure, target, size, output;
  std::uint64_t trials = 100, seed = 1;
  std::vector<std::string> sets;
  bool json = false;
};

ValidateOptions options_of(const ValidateArguments& arguments) {
  ValidateOptions options{
      .trials = arguments.trials, .seed = arguments.seed, .departure = arguments.departure, .target = arguments.target};
  if (!arguments.size.empty()) try {
      options.size = parse_quantity(arguments.size);
    } catch (const Error& error) {
      throw Error(Error::Kind::bad_input, within(say("--size"), error.problems.front()));
    }
  return options;
}

/// Says how long the rest takes, from the time that the first test took.
void note_time(const Terminal& terminal, std::size_t tests, double first) {
  const unsigned processors = std::max(1u, std::thread::hardware_concurrency());
  const double minutes = first * static_cast<double>(tests) / processors / 60.0;
  if (minutes < 1.0)
    note(terminal, say("about {} simulated tests: less than a minute", tests));
  else
    note(terminal, say("about {} simulated tests: some {} min", tests, std::lround(std::ceil(minutes))));
}

int run(const ValidateArguments& arguments, const Terminal& terminal) {
  ValidateOptions options = options_of(arguments);
  if (!arguments.output.empty()) check_output("-o", arguments.output, {arguments.plan}, {".json"});
  const Plan plan = tumble::load_plan(arguments.plan, parse_sets(arguments.sets));
  const double begin = wall_time();
  options.begun = [&](std::size_t tests) { note_time(terminal, tests, wall_time() - begin); };
  const Estimate report = [&] {
    ProgressLine line(terminal);
    return report_of(tumble::validate(plan, options, line.progress()));
  }();
  if (!arguments.output.empty()) write_output(terminal, arguments.output, to_json(report));
  if (arguments.output == "-") return 0;
  if (arguments.json)
    print(to_json(report));
  else if (arguments.output.empty() || !terminal.quiet)
    print(to_text(report, terminal.width, terminal.language));
  return 0;
}

}  // namespace

Verb validate_verb() {
  auto arguments = std::make_shared<ValidateArguments>();
  return {"validate",
          "Show whether the test of a plan holds, and what could go wrong in it without anybody noticing",
          {{"PLAN", &arguments->plan, "plan file (.toml) with a method, [rig], [[schedule]] and [truth]", true},
           {"--trials", &arguments->trials, "simulated tests that are carried out as planned, ten or more"},
           {.name = "--departure",
            .value = &arguments->departure,
            .description = "only this departure: `tumble list departures` shows all",
            .type = "NAME"},
           {.name = "--target",
            .value = &arguments->target,
            .description = "only where it happens to this axis or channel",
            .type = "TARGET"},
           {.name = "--size",
            .value = &arguments->size,
            .description = "only this size of it, with its unit (default: it is searched)",
            .type = "SIZE"},
           {"--seed", &arguments->seed, "seed of the first test; the same seed gives the same answer"},
           {"--json", &arguments->json, "print JSON instead of tables"},
           {"-o,--output", &arguments->output,
            "file to write (.json): `tumble report` makes a page of it,\n`tumble certificate --validation` an annex"},
           sets_argument(arguments->sets, "value that replaces that of the plan: KEY, truth.KEY, rig.KEY; repeatable")},
          "Examples:\n"
          "  tumble validate gyro.toml -o validation.json\n"
          "  tumble validate gyro.toml --departure clock_fast --size \"300 ppm\"\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
