#pragma once

#include <string>

#include "tumble/station/executive.hpp"

namespace tumble::conduct {

/// The row that says that recording was switched on or off at `time` [s].
RunRow row_of(const RecordSwitch& record, double time);
/// "segment 2 of 5 'up', attempt 2"
Sentence words_of(const RecordSwitch& record, std::size_t segments);

}  // namespace tumble::conduct
