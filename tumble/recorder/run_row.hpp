#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/units/sentence.hpp"

/// The words of a run: its states, its endings, what happens, and the rows of its journal.
namespace tumble {

/// States of the executive. docs/station.md says when each is entered.
enum class RunPhase {
  idle,
  preparing,
  ready,
  moving,
  settling,
  dwelling,
  recording,
  between,
  finishing,
  complete,
  holding,
  pausing,
  paused,
  stopping,
  aborting,
  safe,
  faulted
};
std::string_view name(RunPhase phase);
const std::vector<RunPhase>& all_phases();

enum class RunEnding { complete, aborted, stopped, failed, error, faulted };
std::string_view name(RunEnding ending);
/// "complete: the plan has been carried out": the ending and, where there is one, what is said of it.
Sentence said_ending(RunEnding ending, const Sentence& text);

/// Kinds of what happens in a run, in the words of its store.
enum class EventKind {
  accepted,
  answer,
  attempt,
  clock,
  desk,
  end,
  estimate,
  flood,
  guard,
  hold,
  interlock,
  late,
  link,
  link_lost,
  notice,
  phase,
  prompt,
  records,
  refused,
  reply,
  safe,
  settle,
  skip,
  stopped,
  stream,
  timeout,
  unit,
  other  ///< of a store that another version has written
};
/// "link lost"
std::string_view name(EventKind kind);
/// `other` for any other word.
EventKind event_kind(std::string_view word);

/// A row of the journal of a run, as its store keeps it.
struct RunRow {
  enum class Kind {
    power_up,        ///< the unit is switched on for `run`; what earlier attempts of this run recorded no longer counts
    segment_begins,  ///< before the first motion of an attempt
    segment_ends,    ///< with its ending
    unit_out,        ///< `label` is its slot
    run_ends,        ///< with its ending
    records,         ///< recording is switched on, in an attempt
    pauses           ///< recording is switched off
  };
  /// Ending of an attempt: complete, failed, held, paused, or that of the run; ending of a run: that of RunEnding.
  enum class Ending { none, complete, aborted, stopped, failed, error, faulted, held, paused };
  Kind kind = Kind::segment_begins;
  double time = 0.0;        ///< [s]
  std::size_t segment = 0;  ///< index in the schedule
  int run = 1;
  int attempt = 0;
  std::string label = {};
  Ending ending = Ending::none;
  Sentence reason = {};
  std::map<std::string, double> demanded = {},
                                achieved = {};  ///< [SI] by channel: "table.rate"; achieved: the mean read
  std::string rule = {};                        ///< the stopping rule
  double at_least = 0.0;                        ///< [s] of recording before which it is not looked at
  std::optional<double> reached = {};           ///< [s] of recording after which it was reached
  bool operator==(const RunRow&) const = default;
};
/// "complete"; empty: no ending.
std::string_view name(RunRow::Ending ending);
RunRow::Ending row_ending(RunEnding ending);

/// The attempt of each segment that counts, by segment; a segment without one is absent.
std::map<std::size_t, int> counted_attempts(const std::vector<RunRow>& journal);

/// A row of the journal as one JSON value, and back. Throws Error::bad_file for a text that is no row.
std::string text_of(const RunRow& row);
RunRow row_of(const std::string& text);

}  // namespace tumble
