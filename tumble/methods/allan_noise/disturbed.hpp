#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// Parts of a record that are not noise like the rest, in order, none touching another: blocks whose scatter, as it is
/// and about their own straight line, is more than 4 times the median of all (a walk or a warm-up rarely makes the one
/// and never the other), neighbours with more than 1.5 times as much about their line, and one block more either way.
/// Empty too if they would be more than a tenth of the record: then they are how it is.
std::vector<RecordPart> disturbed_parts(const EvenSignal& signal, const BlockScatter& scatter);

/// Sets samples missing.
void set_missing(const std::vector<RecordPart>& parts, EvenSignal& signal);

/// What `disturbed` = "cut" does: sets the parts missing and says so; where there are none, or "keep" is asked for,
/// only points at them.
void set_disturbed_aside(const Settings& settings, EvenSignal& signal, ChannelNoise& result);

/// Table `set_aside`, where anything was.
void describe_set_aside(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
