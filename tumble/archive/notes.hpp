#pragma once

#include <string>
#include <vector>

#include "tumble/archive/deposit.hpp"

/// Notes of events of units and instruments that are not results, and of calibrations that are due.
namespace tumble {

/// Kinds of notes. `adjusted` begins the history of a unit anew; `interval` says how long a calibration counts; a unit
/// or instrument that is `retired` is not due until it is `returned`.
const std::vector<std::string>& note_kinds();

struct ArchiveNote {
  std::string about;  ///< SERIAL or MODEL/SERIAL of a unit, an instrument of the laboratory, or a model
  std::string kind;   ///< one of note_kinds()
  std::string text;   ///< of `interval` a time: "365 day"
  std::string when;   ///< UTC, when it happened; empty: now
};

/// Appends an event to the chain of what the note is about. Throws Error::bad_input with all that is wrong.
void put_note(Archive& archive, const ArchiveNote& note, const ArchiveAct& act);

/// Declares that a result does not count, without another one in its place. The act says why; the result stays.
///
/// Given     sha256  of the result
/// Throws    Error::bad_input where it was replaced or withdrawn already, or no reason is given
void withdraw_result(Archive& archive, const std::string& sha256, const ArchiveAct& act);

/// A unit whose last result that counts is older than its interval.
struct DueUnit {
  UnitName unit;
  std::string last, due;  ///< days: of the last result, and on which it is due
};

/// Units with an interval, their own or that of their model, that ends on that day ("2026-12-31") or before, the
/// earliest first.
std::vector<DueUnit> due_units(const Archive& archive, const std::string& until);

}  // namespace tumble
