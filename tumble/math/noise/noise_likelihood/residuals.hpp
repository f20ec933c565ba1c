#pragma once

#include <vector>

#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/math/noise/noise_likelihood/selection.hpp"

namespace tumble::noise_likelihood {

/// Measured over expected power, in ranges of 30 contrasts and more.
std::vector<NoiseResidual> residuals_of(const BandData& data, const ScoringFit& fit);

/// Chi-square [1] of residuals with a relative error [1] beside their statistical sd.
double chi_square(const std::vector<NoiseResidual>& residuals, double error);

/// Degrees of freedom [1] of that chi-square.
double residual_freedom(const std::vector<NoiseResidual>& residuals, const TriedTerms& one, bool ramp);

/// Degrees of freedom of each band [1] with an independent relative error [1] of the power in each range of
/// frequencies.
std::vector<double> counts_with(std::vector<double> count, double error);

/// The relative error [1] that makes chi-square of the model with all terms equal its degrees of freedom.
double model_error(const BandData& whole, bool ramp, const TriedTerms& full);

}  // namespace tumble::noise_likelihood
