#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::allan_noise {

/// Words that option `deviations` accepts, for its description: "adev, oadev, ... or all".
std::string family_names();

/// Problems of the text of option `deviations`.
Problems family_problems(const std::string& asked);

/// The deviations that option `deviations` asks for. What stands in their way becomes a finding.
void add_family(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// Table `family`, and a figure of each channel's with the overlapping Allan deviation beside them.
void describe_family(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
