#pragma once

#include <vector>

#include "tumble/math/noise/noise_likelihood/spread.hpp"

namespace tumble::noise_likelihood {

/// Values of parameters with their covariance: roots of the coefficients [u], in the order of NoiseFit::terms of the
/// set chosen, then the correlation times [samples] of its processes and the parameters of its filter.
struct NoiseValues {
  std::vector<double> value;
  Matrix covariance;
  std::vector<double> error_variance;  ///< the part of its diagonal that comes from model error
  std::size_t sets = 1;                ///< that the values are averaged over
};

/// The values that the chosen set alone gives.
NoiseValues values_of_chosen(const TermSelection& selection, const LinearNoise& model, const NoiseSpread& known);

/// The values averaged over the sets of terms that the record supports nearly as well: those within 10 of the chosen
/// one by AICc whose terms are all above zero, with weights w = exp(-d/2), d the difference but not below zero:
///   mean = sum w x,   covariance = sum w (C + (x - mean) (x - mean)')
/// A coefficient is zero in a set without its term. A correlation time or a filter that a set lacks is that of the
/// chosen set. Given: statistical_count [1] contrasts of each band.
/// See       docs/decisions/043-noise-averaged-over-models.md
NoiseValues averaged_values(const BandData& data, const std::vector<double>& statistical_count,
                            const TermSelection& selection, const NoiseValues& chosen);

}  // namespace tumble::noise_likelihood
