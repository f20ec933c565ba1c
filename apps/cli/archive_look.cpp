#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "archive_actions.hpp"
#include "archive_views.hpp"
#include "tumble/archive/statistics.hpp"
#include "tumble/formats/temporary_folder.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/recompute.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::cli {
namespace {

/// Units are found by SERIAL or MODEL/SERIAL.
UnitName chosen_unit(const Archive& archive, const std::string& words) {
  return words.empty() ? UnitName{} : find_unit(archive, words);
}

/// A limit in a unit of the parameter [SI].
double limit_of(const std::string& text, const char* option, const Unit& unit, double absent) {
  if (text.empty()) return absent;
  try {
    return parse_si(text, unit);
  } catch (const Error& error) {
    throw Error(Error::Kind::bad_input, say("{} {}: {}", option, Name{text}, error.problems.front()));
  }
}

ParameterLimits limits_of(const ArchiveArguments& arguments, const Unit& unit) {
  ParameterLimits limits;
  limits.lower = limit_of(arguments.minimum, "--min", unit, limits.lower);
  limits.upper = limit_of(arguments.maximum, "--max", unit, limits.upper);
  if (!(limits.lower < limits.upper))
    throw Error(Error::Kind::bad_input,
                say("--min {} is not below --max {}", Name{arguments.minimum}, Name{arguments.maximum}));
  return limits;
}

Unit unit_of(const Archive& archive, const std::string& parameter, const std::string& model) {
  return parameter_over_units(archive, parameter, model).shown;
}

/// An answer as results are shown: tables or JSON, and its figures. Its budget has one line, which says nothing to
/// people.
void show_answer(const Estimate& estimate, const ArchiveArguments& arguments, const Terminal& terminal) {
  Estimate shown = estimate;
  shown.budget.clear();
  print(arguments.json ? to_json(estimate) : to_text(shown, terminal.width, terminal.language));
  if (!arguments.figure.empty()) write_figures(figures_of(estimate), arguments.figure, terminal.language, terminal);
}

/// The file of -o may have any name except that of the archive.
void check_file(const ArchiveArguments& arguments) {
  const auto extension = std::filesystem::path(arguments.output).extension().string();
  if (!arguments.output.empty())
    check_output("-o", arguments.output, {archive_address(arguments.archive)}, {extension});
}

void check_figure(const ArchiveArguments& arguments) {
  if (!arguments.figure.empty()) check_output("--figure", arguments.figure, {}, {".svg"});
}

}  // namespace

int archive_list(const ArchiveArguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const auto units = archived_units(open_archive(arguments.archive), arguments.model);
  print(arguments.json ? units_json(units) : units_text(units, terminal));
  return 0;
}

int archive_show(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& digits = only_word(arguments, "RESULT|FILE|RUN");
  check_file(arguments);
  const Archive archive = open_archive(arguments.archive);
  if (const auto file = find_file(archive, digits)) {
    if (arguments.output.empty())
      throw Error(Error::Kind::bad_input,
                  say("'{}' is the file '{}': -o FILE says where to write it", digits, file->name));
    write_stored(archive, file->sha256, arguments.output);
    note(terminal, say("wrote {}: {}", Name{arguments.output}, Name{file->name}));
    return 0;
  }
  if (const auto run = find_run(archive, digits)) {
    print(arguments.json ? run_json(*run) : run_text(*run, terminal));
    return 0;
  }
  const std::string sha256 = find_result(archive, digits), text = result_text(archive, sha256);
  if (!arguments.output.empty())
    write_output(terminal, arguments.output, text);
  else
    print(arguments.json ? text
                         : to_text(estimate_from_json(text, "result " + digits), terminal.width, terminal.language));
  return 0;
}

int archive_history(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& words = only_word(arguments, "SERIAL");
  check_figure(arguments);
  if (arguments.parameter.empty() && !(arguments.figure + arguments.minimum + arguments.maximum).empty())
    throw Error(Error::Kind::bad_input, "archive history: --figure, --min and --max need --parameter NAME");
  const Archive archive = open_archive(arguments.archive);
  const UnitName unit = find_unit(archive, words);
  if (arguments.parameter.empty()) {
    const auto record = unit_record(archive, unit);
    print(arguments.json ? record_json(record) : record_text(record, terminal));
    return 0;
  }
  DriftRequest request{.what = {arguments.parameter, unit.model, unit}};
  request.limits = limits_of(arguments, unit_of(archive, arguments.parameter, unit.model));
  show_answer(drift_of_unit(archive, request), arguments, terminal);
  return 0;
}

int archive_chart(const ArchiveArguments& arguments, const Terminal& terminal) {
  ChartRequest request{.what = {only_word(arguments, "PARAMETER"), arguments.model, {}}};
  check_figure(arguments);
  const Archive archive = open_archive(arguments.archive);
  request.what.unit = chosen_unit(archive, arguments.unit);
  request.every_day = arguments.every_day;
  if (!arguments.baseline.empty()) {
    const double count = parse_si(arguments.baseline, Unit());
    if (!(count >= 3.0) || count > 1e6 || count != static_cast<double>(static_cast<std::size_t>(count)))
      throw Error(Error::Kind::bad_input,
                  say("--baseline {}: a number of points is expected, 3 or more", Name{arguments.baseline}));
    request.settings.baseline = static_cast<std::size_t>(count);
  }
  show_answer(chart_of_archive(archive, request), arguments, terminal);
  return 0;
}

int archive_summary(const ArchiveArguments& arguments, const Terminal& terminal) {
  SummaryRequest request{.what = {only_word(arguments, "PARAMETER"), arguments.model, {}}};
  check_figure(arguments);
  const Archive archive = open_archive(arguments.archive);
  request.limits = limits_of(arguments, unit_of(archive, request.what.parameter, arguments.model));
  show_answer(summary_of_model(archive, request), arguments, terminal);
  return 0;
}

int archive_due(const ArchiveArguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  const double within = parse_si(arguments.within, Unit::parse("s"));
  const Archive archive = open_archive(arguments.archive);
  const std::string until = utc_day(within);
  const auto calibrations = due_calibrations(archive, until);
  const auto units = due_units(archive, until);
  print(arguments.json ? due_json(calibrations, units) : due_text(calibrations, units, utc_day(0.0), terminal));
  return 0;
}

int archive_verify(const ArchiveArguments& arguments, const Terminal& terminal) {
  no_words(arguments);
  check_file(arguments);
  const Archive archive = open_archive(arguments.archive);
  ArchiveCheck check;
  {
    ProgressLine line(terminal);
    check = verify_archive(archive, line.progress());
  }
  const std::string text = arguments.json ? check_json(check) : check_text(check, terminal);
  if (arguments.output.empty())
    print(text);
  else
    write_output(terminal, arguments.output, text);
  if (!arguments.output.empty() && !check.problems.empty()) complain(terminal, check.problems);
  return check.problems.empty() ? 0 : 3;
}

int archive_recompute(const ArchiveArguments& arguments, const Terminal& terminal) {
  const std::string& digits = only_word(arguments, "RESULT");
  const Archive archive = open_archive(arguments.archive);
  const TemporaryFolder scratch;
  Recomputation again;
  {
    ProgressLine line(terminal);
    again = recompute(archive, find_result(archive, digits), scratch.path().string(), line.progress());
  }
  print(arguments.json ? recomputation_json(again) : recomputation_text(again, terminal));
  return again.same ? 0 : 3;
}

}  // namespace tumble::cli
