#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "tumble/math/noise/noise_bands.hpp"
#include "tumble/math/noise/noise_filter.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble {

struct NoiseLikelihoodOptions {
  std::vector<NoiseTerm> terms{power_law_terms.begin(), power_law_terms.end()};  ///< power laws tried
  double significance = 0.01;   ///< a term remains if its p-value is below this
  std::size_t most_markov = 2;  ///< Gauss-Markov processes tried beside the power laws
  double shortest = 0.0;        ///< [samples] averaging times tau whose frequencies 1/(2 tau) are used
  double longest = std::numeric_limits<double>::infinity();
  bool filter = true;  ///< whether the white noise may have passed a filter before it was sampled
};

/// One set of terms that was compared.
struct NoiseComposite {
  std::vector<UnitTerm> terms;
  double minus_twice_log_likelihood = 0.0;
  int parameters = 0;
  double aicc = 0.0;       ///< less that of the set chosen
  bool supported = false;  ///< each of its terms is significant beside the others
};

/// Slope of a straight trend [u a sample].
struct NoiseRamp {
  bool kept = false;
  double slope = 0.0, sd = 0.0;
  double degrees_of_freedom = 1.0;
  double chance = 1.0;  ///< probability of so much, either way, without a trend
};

/// Measured over expected mean square in a range of frequencies.
struct NoiseResidual {
  double frequency = 0.0;  ///< [cycles a sample]
  double ratio = 1.0, sd = 0.0;
};

struct NoiseFit {
  std::vector<FittedTerm> terms;  ///< quantization, white, flicker, random walk, then the Gauss-Markov processes kept
  /// Covariance of the squared coefficients [u^2] of `terms`, then of T_c [samples] of each process, then of bandwidth
  /// [cycles a sample] and damping of the filter, where there is one.
  Matrix covariance;
  std::vector<double> model_error_variance;  ///< the part of its diagonal that comes from model_error
  /// Reported values in the order of `covariance`: roots of the coefficients [u] free of bias, correlation times,
  /// filter. They and their covariance are averaged over the sets of terms that the record supports nearly as well.
  std::vector<double> value;
  Matrix value_covariance;
  std::vector<double> value_error_variance;  ///< the part of its diagonal that comes from model_error
  std::vector<bool> shown;                   ///< of each term: kept, and its 95 % interval stays above zero
  std::size_t averaged_sets = 1;
  NoiseFilter filter;                  ///< of the white noise
  std::vector<double> filter_freedom;  ///< degrees of freedom of bandwidth and damping
  std::vector<bool> time_at_bound;     ///< of each process: T_c lies at an end of the range that was searched
  double longest_time = 0.0;           ///< [samples] the upper end of that range
  NoiseRamp ramp;
  std::vector<NoiseComposite> composites;  ///< by AICc, the one chosen first
  std::vector<NoiseResidual> residuals;
  double chi_square = 0.0, degrees_of_freedom = 0.0;  ///< of the residuals
  double model_error = 0.0;  ///< relative sd of each residual that the terms miss beyond statistics; 0: none
  double minus_twice_log_likelihood = 0.0;
  double condition = 0.0;
  /// sd of the power along the record over that of Gaussian noise; 1: no more than chance explains. Counted in
  /// covariance.
  double scatter_ratio = 1.0;
};

/// Noise terms of a rate record by maximum likelihood of its contrasts (restricted likelihood beside a ramp).
///
///   -2 ln L = sum_b nu_b (ln s_b + z_b/s_b),   s_b = sum_t c_t E_tb
///
/// over the bands of `noise_bands.hpp`. Of all sets of the four power laws (and the Gauss-Markov processes that lower
/// -2 ln L by more than 13.8 each beside all four) in which every term is significant, the one with the least AICc is
/// chosen, each set with the correlation times and the filter that suit it best. White noise may have passed a filter,
/// where that lowers -2 ln L by more than 30; its coefficient is then the density at frequency zero. Results are
/// averaged over the sets, and the shapes of the filter, within 10 of the chosen one by AICc. The covariance is that of
/// the information of the data; correlation times and filters count as unknown. What the terms cannot follow beyond
/// statistics enters as an independent relative error of the power in each range of frequencies, sized so that
/// chi-square equals its degrees of freedom.
///
/// Throws    Error::bad_data if the bands between `shortest` and `longest` cannot carry a term
/// See       P. Whittle (1953) for the form; exact marginal expectations as in A. M. Sykulski and others, The debiased
///           Whittle likelihood, Biometrika 106 (2019)
NoiseFit fit_noise(const NoiseBands& bands, const NoiseLikelihoodOptions& options);

/// Fills `value` and what belongs to it from `terms` and `covariance`, for a fit of one set of terms.
void take_values_of_terms(NoiseFit& fit);

}  // namespace tumble
