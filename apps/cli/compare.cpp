#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tumble/exchange/comparison.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct CompareArguments {
  std::vector<std::string> results, parameters;
  std::string figure;
  bool json = false, strict = false;
};

/// The figures of the parameters that were asked for; of all, without any.
std::vector<Figure> figures_for(const Comparison& comparison, const CompareArguments& arguments) {
  auto figures = figures_of(comparison);
  std::vector<std::string> names;
  for (const auto& figure : figures) names.push_back(figure.name);
  Problems problems;
  for (const auto& wanted : arguments.parameters)
    if (std::ranges::find(names, wanted) == names.end())
      problems.push_back(
          say("--parameter {}: the results do not all have it{}", Name{wanted}, did_you_mean(wanted, names)));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  if (figures.empty()) throw Error(Error::Kind::bad_input, "the results have no parameter that all of them determine");
  if (!arguments.parameters.empty())
    std::erase_if(figures, [&](const Figure& figure) {
      return std::ranges::find(arguments.parameters, figure.name) == arguments.parameters.end();
    });
  return figures;
}

int run(const CompareArguments& arguments, const Terminal& terminal) {
  if (!arguments.figure.empty()) check_output("--figure", arguments.figure, arguments.results, {".svg"});
  if (!arguments.parameters.empty() && arguments.figure.empty())
    throw Error(Error::Kind::bad_input, "--parameter chooses figures: --figure FIGURE.svg is required with it");
  std::vector<NamedResult> results;
  for (const auto& file : arguments.results)
    results.push_back({file == "-" ? "standard input" : file, read_result(file)});
  const Comparison comparison = compare(std::move(results));
  const auto figures = arguments.figure.empty() ? std::vector<Figure>{} : figures_for(comparison, arguments);
  print(arguments.json ? to_json(comparison) : to_text(comparison, terminal.width, terminal.language));
  write_figures(figures, arguments.figure, terminal.language, terminal);
  const auto changed = [](const ResultPair& pair) {
    return std::ranges::any_of(pair.differences, [](const Difference& one) { return std::abs(one.e_n) > 1.0; });
  };
  return arguments.strict && std::ranges::any_of(comparison.pairs, changed) ? 1 : 0;
}

}  // namespace

Verb compare_verb() {
  auto arguments = std::make_shared<CompareArguments>();
  return {
      "compare",
      "Compare results of one instrument: E_n, and the drift since the last calibration",
      {{"RESULT", &arguments->results, "results (.json) of identify, in order of time; - reads standard input", true},
       {"--json", &arguments->json, "print JSON instead of tables"},
       {"--figure", &arguments->figure,
        "drawing to write (.svg): values with their intervals;\nseveral parameters give FIGURE-1.svg, FIGURE-2.svg, "
        "..."},
       {.name = "--parameter",
        .value = &arguments->parameters,
        .description = "parameter to draw (default: all); repeatable",
        .type = "NAME"},
       {"--strict", &arguments->strict, "exit status 1 if a change is significant: |E_n| above 1"}},
      "Examples:\n"
      "  tumble compare 2025.json 2026.json\n"
      "  tumble compare 2024.json 2025.json 2026.json --figure bias.svg --parameter bias\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
