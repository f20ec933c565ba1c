#pragma once

#include <optional>
#include <string>

#include "tumble/station/executive.hpp"
#include "tumble/station/recorder.hpp"

namespace tumble::conduct {

/// A row of the journal as one JSON value, and back. Throws Error::bad_file for a text that is no row.
std::string text_of(const RunRow& row);
RunRow row_of(const std::string& text);

/// A row that begins or ends a segment as the recorder keeps it; `time` [s] is that of its clock.
std::optional<JournalRow> step_of(const RunRow& row, double time);

/// The moment at which recording was switched on or off, as the recorder keeps it; `time` [s] is that of its clock.
JournalRow step_of(const RecordSwitch& record, double time);
/// "segment 2 of 5 'up', attempt 2"
std::string words_of(const RecordSwitch& record, std::size_t segments);

}  // namespace tumble::conduct
