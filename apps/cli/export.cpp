#include "tumble/tasks/export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct ExportArguments {
  std::vector<std::string> results, sets, drop;
  std::string to, output, inflate;
};

double factor_of(const std::string& text) {
  if (text.empty()) return 1.0;
  if (const auto value = as_number<double>(text)) return *value;
  throw Error(Error::Kind::bad_input, say("--inflate {}: write a number, such as --inflate 10", Name{text}));
}

/// "-" and "gyro_y=-" are standard input.
ExportSource source_of(const std::string& argument) {
  const auto [axis, file] = axis_and_file(argument);
  if (file != "-") return export_source(argument);
  return {"standard input", read_text_file(readable("-")), axis};
}

int run(const ExportArguments& arguments, const Terminal& terminal) {
  const ExportWish wish{arguments.to, parse_sets(arguments.sets), arguments.drop, factor_of(arguments.inflate)};
  find_export(wish.to);
  std::vector<ExportSource> sources;
  std::vector<std::string> files;
  for (const auto& argument : arguments.results) {
    sources.push_back(source_of(argument));
    files.push_back(sources.back().file);
  }
  const bool to_file = !arguments.output.empty() && arguments.output != "-";
  if (to_file)  // any name: the consumer decides what its files are called
    check_output("-o", arguments.output, files, {std::filesystem::path(arguments.output).extension().string()});
  write_output(terminal, to_file ? arguments.output : "-", export_results(sources, wish));
  return 0;
}

}  // namespace

Verb export_verb() {
  auto arguments = std::make_shared<ExportArguments>();
  return {
      "export",
      "Write a calibration and its noise for the software that uses them next",
      {{"RESULT", &arguments->results,
        "results (.json) of identify: a calibration, noise, or both; of a single sensor\n"
        "its axis may be named: gyro_y=RESULT; - reads standard input",
        true},
       {.name = "--to",
        .value = &arguments->to,
        .description = "consumer; `tumble list exports` names them",
        .required = true,
        .type = "NAME"},
       {"-o,--output", &arguments->output, "file to write (default: standard output)"},
       sets_argument(arguments->sets, "setting of the consumer (`tumble list exports NAME`); repeatable"),
       {.name = "--drop",
        .value = &arguments->drop,
        .description = "term that the consumer cannot carry and that may be lost; repeatable",
        .type = "TERM"},
       {.name = "--inflate",
        .value = &arguments->inflate,
        .description = "factor on the noise, for filters that need it larger than it is (default: 1)",
        .type = "FACTOR"}},
      "Examples:\n"
      "  tumble export calibration.json --to c -o calibration.c\n"
      "  tumble export calibration.json noise.json --to kalibr --set accelerometer_walk=\"50 ug/sqrt(h)\" -o imu.yaml\n"
      "  tumble export calibration.json --to imu_tk --drop gyro_acceleration_sensitivity -o imu.calib\n",
      [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
