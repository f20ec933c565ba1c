#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// Where options `correlation` and `hat` ask for it: how the channels sampled together fluctuate together, and what
/// each is worth by itself if all of a kind measure the same input. One result for each stretch.
void describe_together(const std::vector<ChannelRun>& stretches, const std::vector<ChannelNoise>& channels,
                       const Settings& settings, Estimate& estimate);

}  // namespace tumble::allan_noise
