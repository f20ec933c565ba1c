#pragma once

#include <span>
#include <string>
#include <vector>

#include "tumble/core/finding.hpp"
#include "tumble/math/noise/noise_bands.hpp"

namespace tumble::allan_noise {

/// A sine in the record.
struct SpectralLine {
  double frequency = 0.0;  ///< [cycles a sample]
  double amplitude = 0.0;  ///< [u]
  double width = 0.0;      ///< [cycles a sample] either way: the resolution it was found with
};

/// Peaks of the averaged periodogram (Hann window, at most 512 segments of at most 4096 samples spread over the record)
/// that stand 10 sd above the medians on either side, the strongest first, at most 8.
/// Given: values [u]; NaN: missing.
std::vector<SpectralLine> spectral_lines(std::span<const double> values);

/// The bands without those that a line falls into.
NoiseBands without_lines(const NoiseBands& bands, const std::vector<SpectralLine>& lines);

/// Whether the scatter of the fastest contrasts changes along the record by more than 5 standard deviations.
/// Given: begin [s], rate [Hz].
Findings changes_along(const NoiseBands& bands, double begin, double rate, const std::string& label);

}  // namespace tumble::allan_noise
