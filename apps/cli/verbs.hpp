#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "terminal.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble::cli {

/// An option or argument of a verb, and where its value goes. A flag has a bool, a repeatable one a list.
struct Argument {
  std::string name;  ///< "PLAN", "--json", "-o,--output"
  std::variant<bool*, std::string*, std::vector<std::string>*, std::uint64_t*> value;
  std::string description;
  bool required = false;
  std::string type = {};                ///< shown in the help in place of TEXT: "ANGLE"
  std::vector<std::string> words = {};  ///< what is accepted; empty: any text
  char separator = 0;                   ///< between several values of one occurrence; 0: one value each
  std::string bytes = {};               ///< a size with a unit; its default as the help shows it: "2 GB"
  /// What shells offer here, of which the verb itself refuses all others.
  std::vector<std::string> actions = {};
};

/// A word of the command line: its options, and what to do once they are read.
struct Verb {
  std::string name, summary;
  std::vector<Argument> arguments;
  std::string footer;
  std::function<int(const Terminal&)> run;  ///< returns the exit status
};

Verb list_verb();
Verb init_verb();
Verb inspect_verb();
Verb simulate_verb();
Verb identify_verb();
Verb compensate_verb();
Verb predict_verb();
Verb report_verb();
Verb export_verb();
Verb certificate_verb();
Verb compare_verb();
Verb rehearse_verb();
Verb run_verb();
Verb resume_verb();
Verb stop_verb();
Verb answer_verb();
Verb station_verb();
Verb virtual_rig_verb();
Verb convert_verb();
Verb record_verb();
Verb seal_verb();
Verb archive_verb();
Verb population_verb();
Verb validate_verb();
Verb fleet_verb();

/// Exit status of a wrong command line, plan or option.
constexpr int usage = 2;

/// Reads the command line and runs its verb. Returns the exit status; throws what the verb throws.
int run_command_line(int argc, char** argv, const std::vector<Verb>& verbs, Terminal& terminal);

/// The repeatable option --set key=value; and what it may say about a recording.
Argument sets_argument(std::vector<std::string>& texts, std::string what);
Argument reading_sets(std::vector<std::string>& texts, const std::string& before = "information that the file");
/// The repeatable option --topic NAME, for logs that hold several streams.
Argument topic_argument(std::vector<std::string>& topics);
/// The repeatable option --departure NAME[:TARGET][=SIZE], for tests that are not carried out as planned.
Argument departure_argument(std::vector<std::string>& departures);
/// `topics` are what --topic names. Throws Error::bad_input for a text without "=".
tumble::Sets parse_sets(const std::vector<std::string>& texts, const std::vector<std::string>& topics = {});

/// Where to read what the user wrote as `path`: standard input for "-", which is kept in a temporary file
/// and can be read once. Throws Error::bad_input for a terminal, Error::bad_file.
std::string readable(const std::string& path);
/// A text with the place of that temporary file replaced by "standard input".
std::string as_written(std::string text);
/// The recording on standard input, in any format. Throws as read_recording() and readable().
Recording read_standard_input(const ReadOptions& options, const Progress& progress);

/// A result from its file, or from standard input for "-". Throws Error::bad_file.
Estimate read_result(const std::string& path);
/// To the file as a whole, or to standard output for "-"; a file is noted. Throws Error::bad_file.
void write_output(const Terminal& terminal, const std::string& path, const std::string& content);
/// To `path`, "noise.svg", or to "noise-1.svg", "noise-2.svg", ... where there are several; each is noted.
/// Throws Error::bad_file.
void write_figures(const std::vector<Figure>& figures, const std::string& path, Language language,
                   const Terminal& terminal);

/// `option` is the one that names the file, for the message: "-o", "--figure".
/// Throws Error::bad_input when `output` is one of `inputs`, has none of the `extensions`, or lies in a folder that is
/// not there: before any work is done.
void check_output(const std::string& option, const std::string& output, const std::vector<std::string>& inputs,
                  const std::vector<std::string>& extensions);
/// For the recording of -o: as check_output(), with the extensions of the formats that can be written.
void check_recording_output(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace tumble::cli
