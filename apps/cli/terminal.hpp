#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/progress.hpp"

namespace tumble::cli {

/// What a run of the program may say and how. Results go to standard output, everything else to standard error.
struct Terminal {
  bool quiet = false;   ///< no notes and no progress; errors are always said
  bool colour = false;  ///< standard error is a terminal and NO_COLOR is not set
  bool live = false;    ///< standard error is a terminal: progress may be drawn
};

Terminal terminal_of_process();

/// To standard output, all of it, without control characters. Throws Error::bad_file when it cannot be written (a full
/// disk behind it).
void print(std::string_view text);

/// "tumble: wrote fog.h5", unless quiet.
void note(const Terminal& terminal, const std::string& message);
/// "error:" and the problems, each on a line of its own.
void complain(const Terminal& terminal, const std::vector<std::string>& problems);
inline void complain(const Terminal& terminal, const std::string& problem) { complain(terminal, std::vector{problem}); }

/// Draws how far the work is, on one line of standard error that it clears when done. Nothing unless live.
class ProgressLine {
 public:
  explicit ProgressLine(const Terminal& terminal) : shown_(terminal.live && !terminal.quiet) {}
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Valid as long as this object.
  Progress progress();

 private:
  void draw(double done, std::string_view what);

  bool shown_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace tumble::cli
