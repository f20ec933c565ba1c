#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <string>
#include <vector>

#include "terminal.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble::cli {

/// A word of the command line: its options, and what to do once they are read.
struct Verb {
  CLI::App* app = nullptr;
  std::function<int(const Terminal&)> run;  ///< returns the exit status
};

Verb add_list(CLI::App& program);
Verb add_inspect(CLI::App& program);
Verb add_simulate(CLI::App& program);
Verb add_identify(CLI::App& program);
Verb add_compensate(CLI::App& program);
Verb add_predict(CLI::App& program);
Verb add_report(CLI::App& program);
Verb add_convert(CLI::App& program);

/// The repeatable option --set key=value.
void add_sets(CLI::App& verb, std::vector<std::string>& texts, const std::string& what);
/// Throws Error::bad_input for a text without "=".
tumble::Sets parse_sets(const std::vector<std::string>& texts);

/// The text of a file; Error::bad_file. And the result in it.
Estimate read_result(const std::string& path);

/// Throws Error::bad_input when `output` is one of `inputs`, has none of the `extensions`, or lies in a folder that is
/// not there: before any work is done.
void check_output(const std::string& output, const std::vector<std::string>& inputs,
                  const std::vector<std::string>& extensions);
/// For an output that is a recording: as check_output(), with the extensions of the formats that can be written.
void check_recording_output(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace tumble::cli
