#pragma once

#include <vector>

#include "tumble/core/settings.hpp"
#include "tumble/math/allan.hpp"
#include "tumble/math/noise_likelihood.hpp"
#include "tumble/methods/allan_noise/describe.hpp"
#include "tumble/methods/allan_noise/even_signal.hpp"

namespace tumble {

/// Noise terms by maximum likelihood of the record, and what length of record each would take.
void fit_likelihood(const EvenSignal& signal, const Settings& settings, ChannelNoise& result);

/// Noise terms from the Allan variances by generalised least squares. A trend and the noise about it, where the trend
/// stands out of that noise; else the noise of the record as it is.
///
/// Given     curve  overlapping Allan deviation of the signal, made with `options`
NoiseFit fit_allan_curve(const EvenSignal& signal, const std::vector<DeviationPoint>& curve,
                         const AllanOptions& options, const Settings& settings);

}  // namespace tumble
