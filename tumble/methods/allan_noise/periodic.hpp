#pragma once

#include <span>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/lines.hpp"

namespace tumble::allan_noise {

/// A record as sines and noise.
struct PeriodicFit {
  std::vector<FittedLine> lines;        ///< the strongest first
  std::vector<SpectralLine> wandering;  ///< lines whose frequency or amplitude is not constant
  NoiseBands bands;                     ///< of the residual, without the bands that the wandering lines reach
  NoiseFit fit;
};

constexpr std::size_t most_fitted_lines = 16;

/// Sines of the record, fitted and subtracted, and the remaining noise: peaks of averaged periodograms (of the record
/// where its terms do not follow it, and of means over 16 samples) and of the slow sines of the bands. What does not
/// stand out of the noise beside it beyond any chance is put back; what departs from a sine by 30 % and more along the
/// record remains in it and its bands are not used.
///
/// Given     values      [u] of the record; NaN: missing
///           bands, fit  of the record as it is
PeriodicFit fit_beside_lines(std::span<const double> values, const NoiseBands& bands, const NoiseFit& fit,
                             const NoiseLikelihoodOptions& options);

/// Allan variance [u^2] that a line gives at `factor` samples.
double allan_variance_of(const FittedLine& line, double factor);

/// Table `lines`, where there are any.
void describe_lines(const std::vector<ChannelNoise>& channels, Estimate& estimate);

}  // namespace tumble::allan_noise
