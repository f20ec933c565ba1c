#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// The deviation at every averaging time up to `longest_fraction` where taus = "all" asks for it, and the Hadamard
/// deviation where the family (added before) has it.
void add_all_taus(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// A curve of them in the figure of each channel's deviation (of the family's, for the Hadamard deviation); the limits
/// are those of the curve's points, between which they are interpolated.
void describe_all_taus(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
