#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/report/problem_json.hpp"

namespace tumble::jobs {

/// How a process of the program ended.
struct Outcome {
  int status = 0;        ///< exit status; -1: it was ended by a signal, or could not be started
  std::string messages;  ///< what it wrote to standard error
  std::string problems;  ///< what it refused, as JSON (report/problem_json.hpp); empty: it said nothing so
};

/// Why a program has failed: what it has handed on, or else all that it said (a fault of memory, a signal). Files are
/// named from `root` on.
CodedProblems problems_of(const Outcome& outcome, const std::string& root);

/// Takes the line "problems [...]" out of what a process hands on.
void take_problems(std::string& waiting, std::string& problems);

/// Starts the program, reads its progress and messages until it ends.
///
/// Given  started   gets the process while it runs, and 0 when it has ended
///        progress  done [1] from 0 to 1, and what is done
Outcome run_process(const std::string& program, const std::vector<std::string>& arguments,
                    const std::function<void(int)>& started,
                    const std::function<void(double, const std::string&)>& progress);

/// Starts the program so that it goes on when this process ends, in a session of its own: a run must stay with its rig.
///
/// Given     messages  a file that takes what it writes, behind a line with the verb; replaced
///
/// Returned  a descriptor, to be closed by the caller, that gives what the process refuses and reads its end when the
///           process ends; -1: not started
///
/// Throws    Error::bad_file where the file cannot be written: nothing was started
int start_detached(const std::string& program, const std::vector<std::string>& arguments, const std::string& messages);

/// Starts a program that reads `input` and answers on standard output, which `output` gets.
Outcome run_process(const std::string& program, const std::vector<std::string>& arguments, const std::string& input,
                    std::string& output, const std::function<void(int)>& started);

/// Ends a process and what it started.
void end_process(int process);

}  // namespace tumble::jobs
