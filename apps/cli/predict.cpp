#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "prior_option.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/optimise.hpp"
#include "tumble/tasks/shorten.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct PredictArguments {
  std::string plan, output, criterion, total_time, step;
  std::vector<std::string> sets, terms;
  bool json = false, optimise = false;
  ArchiveOptions archive;
};

/// What only --optimise understands.
tumble::OptimiseOptions options_of(const PredictArguments& arguments) {
  tumble::OptimiseOptions options;
  options.terms = arguments.terms;
  Problems problems;
  const auto quantity = [&](const char* name, const std::string& text, const char* unit) -> std::optional<double> {
    if (text.empty()) return std::nullopt;
    try {
      return parse_si(text, Unit::parse(unit));
    } catch (const Error& error) {
      for (const auto& problem : error.problems) problems.push_back(say("{} {}: {}", name, text, problem));
      return std::nullopt;
    }
  };
  options.total_time = quantity("--total-time", arguments.total_time, "h");
  options.step = quantity("--step", arguments.step, "deg").value_or(options.step);
  if (arguments.criterion == "D") options.criterion = DesignCriterion::D;
  if (!arguments.optimise)
    for (const auto& [name, given] : {std::pair{"--criterion", !arguments.criterion.empty()},
                                      {"--total-time", !arguments.total_time.empty()},
                                      {"--step", !arguments.step.empty()},
                                      {"-o", !arguments.output.empty()}})
      if (given) problems.push_back(say("{} needs --optimise", name));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return options;
}

/// The comment above a plan that was found, with what the command line said beyond the file.
std::string heading(const PredictArguments& arguments) {
  std::string text = "# Schedule found by: tumble predict " + arguments.plan + " --optimise";
  if (!arguments.criterion.empty()) text += " --criterion " + arguments.criterion;
  if (!arguments.total_time.empty()) text += " --total-time \"" + arguments.total_time + "\"";
  if (!arguments.step.empty()) text += " --step \"" + arguments.step + "\"";
  if (!arguments.terms.empty()) text += fmt::format(" --terms {}", fmt::join(arguments.terms, ","));
  for (const auto& set : arguments.sets) text += " --set '" + set + "'";
  return text + "\n";
}

int optimise(const PredictArguments& arguments, const tumble::OptimiseOptions& options, const Plan& plan,
             const Terminal& terminal) {
  const auto found = [&] {
    ProgressLine line(terminal);
    if (!plan.prior.from.empty() && !options.total_time) return tumble::shorten(plan, options, line.progress());
    return tumble::optimise(plan, options, line.progress());
  }();
  print(arguments.json ? to_json(found.estimate) : to_text(found.estimate, terminal.width, terminal.language));
  if (arguments.output.empty()) return 0;
  write_file_atomically(arguments.output, heading(arguments) + tumble::plan_with_schedule(plan, found.schedule));
  note(terminal, say("wrote {}", Name{arguments.output}));
  return 0;
}

int run(const PredictArguments& arguments, const Terminal& terminal) {
  const auto options = options_of(arguments);
  if (!arguments.output.empty()) check_output("-o", arguments.output, {arguments.plan}, {".toml"});
  auto plan = tumble::load_plan(arguments.plan, parse_sets(arguments.sets));
  read_prior_from(arguments.archive, plan);
  if (arguments.optimise) return optimise(arguments, options, plan, terminal);
  const auto estimate = [&] {
    const ProgressLine line(terminal, "predicting");
    return arguments.terms.empty() ? tumble::predict(plan) : tumble::predict_model(plan, arguments.terms);
  }();
  print(arguments.json ? to_json(estimate) : to_text(estimate, terminal.width, terminal.language));
  return 0;
}

}  // namespace

Verb predict_verb() {
  auto arguments = std::make_shared<PredictArguments>();
  return {"predict",
          "Predict the uncertainty of every parameter before the test",
          {{"PLAN", &arguments->plan, "plan file (.toml) with [instrument], [rig], [[schedule]] and [truth]", true},
           {"--json", &arguments->json, "print JSON instead of a table"},
           {"--optimise", &arguments->optimise,
            "find the positions, rates and dwell times that the rig allows with the smallest uncertainties"},
           {.name = "--criterion",
            .value = &arguments->criterion,
            .description = "A: mean variance (default); D: determinant of the covariance",
            .words = {"A", "D"}},
           {.name = "--total-time",
            .value = &arguments->total_time,
            .description = "total time of all power-ups (default: that of the plan)",
            .type = "TIME"},
           {.name = "--step",
            .value = &arguments->step,
            .description = "step of the grid of positions (default: 15 deg)",
            .type = "ANGLE"},
           {.name = "--terms",
            .value = &arguments->terms,
            .description = "only these terms of the model, the others are assumed to be known; repeatable",
            .type = "TERM,...",
            .separator = ','},
           {"-o,--output", &arguments->output, "plan to write, with the new schedule (.toml)"},
           archive_argument(arguments->archive),
           sets_argument(arguments->sets, "value that replaces that of the plan: KEY, truth.KEY, rig.KEY; repeatable")},
          "Examples:\n"
          "  tumble predict gyro.toml\n"
          "  tumble predict gyro.toml --optimise --total-time \"2 h\" -o best.toml\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
