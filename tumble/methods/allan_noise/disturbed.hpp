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
/// Also empty if they would be more than a tenth of the record: then the record is like this.
std::vector<RecordPart> disturbed_parts(const EvenSignal& signal, const BlockScatter& scatter);

/// Sets samples missing.
void set_missing(const std::vector<RecordPart>& parts, EvenSignal& signal);

/// Sets the disturbed parts missing, with a finding; where nothing is disturbed, or `disturbed` = "keep", the finding
/// only names disturbed blocks.
void set_disturbed_aside(const Settings& settings, EvenSignal& signal, ChannelNoise& result);

/// Table `set_aside`, if a part was set aside.
void describe_set_aside(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
