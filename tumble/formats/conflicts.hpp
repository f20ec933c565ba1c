#pragma once

#include <string>
#include <vector>

#include "tumble/core/read_options.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

/// Units that `options` and the recording itself state differently, a sentence for each.
Problems unit_conflicts(const Recording& recording, const ReadOptions& options);
/// The sentence for a rate [Hz] that was said of a recording none of whose channels has it; empty where one has.
std::string rate_conflict(const Recording& recording, double said);

/// Throws Error::bad_data with all that `options` say otherwise than the recording, or the first block of it.
void refuse_conflicts(const Recording& recording, const ReadOptions& options);

}  // namespace tumble
