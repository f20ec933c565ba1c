#pragma once

#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/core/recording.hpp"

namespace tumble {

/// Ends each mark that says no end itself as the schedule says. A label that several lengths of segments have says nothing.
void end_marks(const Schedule& schedule, std::vector<Mark>& marks);

/// The marks of the file; without any, segment k begins after the durations [s] of those before it, counted from the
/// first stamp of the recording.
void mark_from_schedule(const Plan& plan, const RecordingEntry& entry, Recording& recording);

}  // namespace tumble
