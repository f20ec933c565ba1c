#pragma once

#include <cstdint>
#include <vector>

#include "tumble/math/noise/block_cosines.hpp"
#include "tumble/math/noise/noise_bands.hpp"

namespace tumble {

/// sum_i w_i w_{i+h} for h = 0 ... w.size() - 1 [w^2].
std::vector<double> lag_products(const std::vector<double>& weights);

/// sum_h g_h v_h over all lags h of either sign, with v those of a symmetric sequence from lag 0 on [g v].
double over_lags(const std::vector<double>& products, const std::vector<double>& covariances);

/// Covariances [1] at lags 0 ... lags - 1 of means over `unit` samples of a Gauss-Markov process of unit variance, less
/// the variance of such a mean. time: T_c [samples].
std::vector<double> markov_below_variance(double unit, double time, int lags);

}  // namespace tumble

namespace tumble::noise_bands {

/// Products of weights at each lag, summed over all blocks of one scale of which some lack values: the weights of their
/// cosines (of the values less the mean of the present ones, zero where missing) and of their means.
struct PatternsOfScale {
  double contrasts = 0.0;  ///< independent ones in a band: a block with k of p values has (k-1)/(p-1)
  std::vector<std::vector<double>> products;  ///< [order][lag] of the cosine's weights, divided by `contrasts`
  std::vector<double> excess;                 ///< [lag] of the weights of the means, less those of whole blocks
  double share = 0.0;                         ///< by which a variance of independent values is divided in their means
};

}  // namespace tumble::noise_bands

namespace tumble {

/// Given: sums over the blocks of a scale, of `radix` values each.
noise_bands::PatternsOfScale patterns_of(const ContrastSums& sums, int radix);

/// Variance that missing values add to the means with which the next scale works.
/// Given: before (of the values of this scale; may be null); unit [samples] of these values.
std::shared_ptr<const LostSamples> lost_after(const std::shared_ptr<const LostSamples>& before,
                                              const noise_bands::PatternsOfScale& patterns, double unit);

}  // namespace tumble
