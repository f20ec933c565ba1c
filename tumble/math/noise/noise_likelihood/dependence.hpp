#pragma once

#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/noise/noise_bands.hpp"

namespace tumble::noise_likelihood {

/// Terms with their squared coefficients [u^2].
struct WeightedTerm {
  UnitTerm unit;
  double squared = 0.0;
  std::vector<double> autocovariance;  ///< of white noise that was filtered, for a density of one; else empty
};

/// Part of the covariance of weighted sums of squares that comes from the covariance between contrasts:
///   U_t = 1/2 sum_b weight_bt count_b z_b,   covariance 1/2 sum over pairs of different contrasts w_t w_u C^2.
/// Counted: cosines of one scale, in the same block and up to three blocks apart; of neighbouring scales; of the last
/// scale with the sines; of the ends of the sines under quantization. The others are far apart in time or frequency.
///
/// Given     weights  [bands x sums]
/// Returned  [sums x sums]
Matrix covariance_of_dependence(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms,
                                const Matrix& weights);

/// The part of the mean square of each band [u^2] that quantization at the two ends of the record gives: these two
/// values are in all sines.
std::vector<double> variance_of_ends(const std::vector<NoiseBand>& bands, const std::vector<WeightedTerm>& terms);

/// Covariance [u^2] of means over `unit` [samples] at a lag of `lag` [units], up to what contrasts do not see.
double unit_mean_covariance(const std::vector<WeightedTerm>& terms, double unit, int lag);

}  // namespace tumble::noise_likelihood
