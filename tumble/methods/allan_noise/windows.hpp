#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// The deviation along the record where option `windows` asks for it, and a finding if it changes.
void add_windows(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// Figures of the deviation of each window over that of the record, and table `windows`.
void describe_windows(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
