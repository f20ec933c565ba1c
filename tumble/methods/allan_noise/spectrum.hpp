#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// The power spectral density where option `spectrum` asks for one. What stands in its way becomes a finding.
void add_spectrum(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// Figures of the spectra beside that of the identified terms, and table `spectra`.
void describe_spectra(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
