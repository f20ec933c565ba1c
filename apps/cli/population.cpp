#include <fmt/format.h>

#include <memory>

#include "archive_options.hpp"
#include "tumble/archive/populations.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct PopulationArguments {
  PopulationQuery query;
  ArchiveOptions archive;
  std::string components, output;
  bool json = false;
};

int run(const PopulationArguments& arguments, const Terminal& terminal) {
  if (!arguments.output.empty()) check_output("-o", arguments.output, {}, {".json"});
  const Archive archive = open_archive(arguments.archive);
  const Estimate estimate = arguments.components.empty()
                                ? population_of(archive, arguments.query)
                                : components_of(archive, arguments.query, arguments.components);
  if (!arguments.output.empty()) write_output(terminal, arguments.output, to_json(estimate));
  if (arguments.output == standard_output) return 0;
  if (arguments.json)
    print(to_json(estimate));
  else if (arguments.output.empty() || !terminal.quiet)
    print(to_text(estimate, terminal.width, terminal.language));
  return 0;
}

}  // namespace

Verb population_verb() {
  auto arguments = std::make_shared<PopulationArguments>();
  return {
      "population",
      "What the archive says of a further unit of a model, and why results differ",
      {{"MODEL", &arguments->query.model, "model of the units, as their results name it", true},
       archive_argument(arguments->archive),
       {.name = "--method",
        .value = &arguments->query.method,
        .description = "results of this method (default: the only one)",
        .type = "METHOD"},
       {.name = "--components",
        .value = &arguments->components,
        .description =
            "instead: unit to unit, rig to rig, day to day and turn-on to\nturn-on of this parameter, from all results",
        .type = "PARAMETER"},
       {.name = "--without",
        .value = &arguments->query.without,
        .description = "a unit that is not to be part of it",
        .type = "SERIAL"},
       {"--json", &arguments->json, "print JSON instead of tables"},
       {"-o,--output", &arguments->output,
        "file to write (.json): a plan can name it as its prior, `tumble report` shows it"}},
      "Examples:\n"
      "  tumble population pendulous_accelerometer --archive lab.db -o population.json\n"
      "  tumble population pendulous_accelerometer --components bias --archive lab.db\n"
      "  tumble identify plan.toml data.h5 --set prior=population.json\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
