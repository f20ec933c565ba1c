#pragma once

#include <string>

#include "live_block.hpp"
#include "terminal.hpp"
#include "tumble/desk/run_texts.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::cli {

/// What a person sees of a run: on a terminal one block that is drawn again, and lines for what happened; elsewhere the
/// lines alone.
class RunDisplay {
 public:
  explicit RunDisplay(const Terminal& terminal) : terminal_(terminal), block_(terminal) {}
  void show(const RunView& view);
  void tell(const Note& note, double time);
  void ask(const Prompt& prompt);
  void end() { block_.clear(); }

 private:
  const Terminal& terminal_;
  LiveBlock block_;
};

/// A line for what a person would want to know; empty for steps that happen every day.
std::string note_line(const Note& note, double time, Language language);

inline constexpr long an_hour = static_cast<long>(hour);  ///< [s]

}  // namespace tumble::cli
