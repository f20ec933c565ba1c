#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/language/text.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/units/error.hpp"

namespace tumble::cli {

/// What a run of the program may say and how. Results go to standard output, everything else to standard error.
struct Terminal {
  bool quiet = false;                     ///< no notes and no progress; errors are always said
  bool colour = false;                    ///< standard error is a terminal and NO_COLOR is not set
  bool live = false;                      ///< standard error is a terminal: progress may be drawn
  std::size_t width = 100;                ///< characters in a line of results: those of the terminal, within limits
  Language language = Language::english;  ///< of what people read
};

Terminal terminal_of_process();

/// The language of --lang among the words of the command line, or else the one that LC_ALL, LC_MESSAGES or LANG names
/// (the first of them that is set): Chinese where it begins with zh.
Language language_of_process(const std::vector<std::string>& words);

/// A sentence to standard output, in the language of the terminal.
void print_said(const Terminal& terminal, const Sentence& said);

/// A table whose headings are said in the language of the terminal.
std::string table_said(const Terminal& terminal, std::vector<TextColumn> columns);

/// To standard output, all of it, without control characters. Throws Error::bad_file when it cannot be written (a full
/// disk behind it).
void print(std::string_view text);

/// "tumble: wrote fog.h5", unless quiet.
void note(const Terminal& terminal, const Sentence& message);
/// "error:" and the problems, each on a line of its own.
void complain(const Terminal& terminal, const Problems& problems);
/// Tells the program that has started this one: a line "problems [...]" to the descriptor that TUMBLE_PROBLEMS names,
/// or else to that of progress.
void hand_on(Error::Kind kind, const Problems& problems);
inline void complain(const Terminal& terminal, const Problem& problem) { complain(terminal, Problems{problem}); }

/// Draws how far the work is, on one line of standard error that it clears when done. Work that says nothing for a
/// while is seen to go on: the seconds count. Nothing unless live.
class ProgressLine {
 public:
  explicit ProgressLine(const Terminal& terminal, std::string_view what = "");
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Valid as long as this object.
  Progress progress();

 private:
  using Clock = std::chrono::steady_clock;
  void note_done(double done, std::string_view what);
  void draw();
  void draw_until_ended();

  bool shown_;
  Language language_;
  bool drawn_ = false, ended_ = false;
  double done_ = 0.0;
  std::string what_;
  Clock::time_point begin_ = Clock::now(), drawn_at_{};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread ticking_;
};

}  // namespace tumble::cli
