#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "tumble/math/noise/noise_likelihood/dependence.hpp"
#include "tumble/math/noise/noise_likelihood/selection.hpp"

namespace tumble::noise_likelihood {

/// Degrees of freedom [1] of the chi-square with that skewness [1]: sqrt(8/nu).
inline double freedom_of_skewness(double skewness) {
  constexpr double least = 1e-6;  // of the square: more than 8e6 degrees of freedom are normal
  return 8.0 / std::max(skewness * skewness, least);
}

/// Columns of the terms above zero, then the derivatives by ln T_c of the processes, and last those by the logarithms
/// of the filter's parameters, at the fitted model.
struct LinearNoise {
  Matrix x;                            ///< [bands x columns]
  std::vector<std::size_t> terms;      ///< index in NoiseFit::terms of the first columns
  std::vector<std::size_t> processes;  ///< of the columns after them
  int filter_parameters = 0;           ///< number of the last columns
};

/// Given: range  where there is one, a correlation time at its end counts as known
LinearNoise linear(const BandData& data, const TriedTerms& chosen, const SearchRange* range = nullptr);

std::vector<WeightedTerm> weighted_terms(const TriedTerms& chosen);

/// Covariance of the estimates, taken as linear sums of the mean squares.
struct NoiseSpread {
  Matrix covariance, by_error;
  std::vector<double> widening;  ///< of the sd by dependence
  double condition = 0.0;
  double scatter_ratio =
      1.0;  ///< sd of the power along the record over that of Gaussian noise, the largest of any scale
};

/// Covariance of the noise terms; `statistical_count` [1] holds how many independent contrasts each band has. It is the
/// inverse of the information, or, where contrasts depend on each other, that of the maximum: with A the information
/// and B the covariance of the derivative of ln L, A^-1 B A^-1; where the power scatters more along the record than
/// that of Gaussian noise, this is part of B (excess.hpp).
NoiseSpread spread(const BandData& data, const std::vector<double>& statistical_count, const LinearNoise& model,
                   const TriedTerms& chosen);

/// Degrees of freedom for which value +- t sd holds the coefficient with 95 %: so that the chances of an estimate as
/// low from the upper end and as high from the lower end add up to 5 %.
///
/// Given     x        [bands x columns] of the model; s [bands] expected mean squares
///           squared  coefficient [u^2]; value, sd  of its root [u]; widening [1] of the sd
/// Returned  degrees of freedom [1]
double interval_freedom(const BandData& data, const Matrix& x, const std::vector<double>& s, std::size_t column,
                        double squared, double value, double sd, double widening);

/// Degrees of freedom [1] for a correlation time, whose logarithm is nearly normal and whose sd grows as its power 3/2:
/// an estimate that is low states too small a sd.
///
/// Given     sd  of the logarithm [1]
double time_freedom(double sd);

/// Degrees of freedom [1] for a parameter of a filter, whose logarithm has this sd [1] at each of its values.
double logarithm_freedom(double sd);

/// Where -2 ln L rises by 2.71 (95 % one-sided) above its least as the coefficient of `column` grows.
///
/// Given     others [bands x columns], column [bands] of the terms; value, sd of the root of the coefficient [u]
/// Returned  upper limit of the root [u]
double upper_limit(const BandData& data, const Matrix& others, std::span<const double> column, bool ramp,
                   const ScoringFit& free, double value, double sd);

}  // namespace tumble::noise_likelihood
