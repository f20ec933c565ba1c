#pragma once

#include <vector>

#include "tumble/math/noise/noise_likelihood/spread.hpp"

namespace tumble::noise_likelihood {

/// By how much the power of the contrasts scatters more along the record than that of Gaussian noise does: heavy tails,
/// outliers, knocks, noise that changes.
struct ExcessScatter {
  double unit = 1.0;      ///< [samples] of the values of a scale
  double relative = 0.0;  ///< variance of the mean power of the scale beyond that of Gaussian noise, over its square
  double ratio = 1.0;     ///< sd of the mean power over that of Gaussian noise
};

/// Excess scatter of each scale of `bands.scatter`, fast scales first. The sum of the powers of each group over their
/// means,
///   q_g = sum_k (S_gk/z_k - n_g),   variance V = G/(G-1) sum_g q_g^2,
/// has the variance V_0 = 2 sum n of Gaussian noise, with the dependence of the contrasts under the terms counted. The
/// part that exceeds it by 4 of its sd is an excess, and belongs to the slower scales too: their values are means of
/// the same samples.
std::vector<ExcessScatter> excess_scatter(const BandData& data, const std::vector<WeightedTerm>& terms);

/// Covariance of the sums U_t = 1/2 sum_b weight_bt count_b z_b that comes from an excess, which is common to all
/// bands:
///   1/4 v_t v_u,   v_t = sum_b e_b weight_bt count_b s_b,   e_b the root of the relative variance in the scale of the
///   band.
/// Given: count [bands] of independent contrasts, s [bands] expected mean squares, weights [bands x sums].
Matrix covariance_of_excess(const BandData& data, const std::vector<ExcessScatter>& excess,
                            const std::vector<double>& count, const std::vector<double>& s, const Matrix& weights);

}  // namespace tumble::noise_likelihood
