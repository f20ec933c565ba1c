#pragma once

#include "tumble/math/noise/noise_likelihood/selection.hpp"

namespace tumble::noise_likelihood {

/// Probability that a term that is not there raises the likelihood as steeply as the record does where the terms
/// `without` it are fitted best: the derivative of ln L by its coefficient, less what the other parameters take of
/// it (a correlation time at the end of its range takes nothing), is a sum of mean squares, of which variance and third
/// moment make a shifted chi-square. Covariances between contrasts are counted, which the fall of -2 ln L does not.
///
/// Given     column  [bands] expected mean squares of the term
/// Returned  probability [1]; 0 where these covariances matter little: the fall of -2 ln L is then the stronger test
/// See       score test with the variance that holds for a composite likelihood: C. Varin, N. Reid and D. Firth, An
///           overview of composite likelihood methods, Statistica Sinica 21 (2011)
double chance_by_slope(const BandData& data, const TriedTerms& without, std::span<const double> column,
                       const SearchRange& range);

}  // namespace tumble::noise_likelihood
