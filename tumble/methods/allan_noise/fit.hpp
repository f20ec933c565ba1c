#pragma once

#include <functional>
#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/math/stability/allan.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/reduce/even_signal.hpp"

namespace tumble::allan_noise {

/// Noise terms by maximum likelihood of the record, and what length of record each would take. Bands that lines fall
/// into are not used.
///
/// Given     bands   of the record, which begins at `begin` [s]; result.rate is its sampling rate
///           lines   finds the lines in the record; asked only where the terms alone do not follow it
void fit_likelihood(NoiseBands bands, const std::function<std::vector<SpectralLine>()>& lines, double begin,
                    const Settings& settings, ChannelNoise& result);

/// The likelihood fit with sines fitted beside the noise and subtracted.
void fit_likelihood_and_lines(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// Noise terms from the Allan variances by generalised least squares. A trend and the noise about it, where the trend
/// stands out of that noise; else the noise of the record as it is.
///
/// Given     curve  overlapping Allan deviation of the signal, made with `options`
NoiseFit fit_allan_curve(const EvenSignal& signal, const std::vector<DeviationPoint>& curve,
                         const AllanOptions& options, const Settings& settings);

}  // namespace tumble::allan_noise
