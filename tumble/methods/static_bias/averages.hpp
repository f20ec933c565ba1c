#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan_covariance.hpp"

namespace tumble::static_bias {

/// Scatter of the averages of a record about their mean: s^2 = sum (a_i - mean a)^2/(M - 1).
struct AverageScatter {
  std::size_t averages = 0;  ///< M
  double variance = 0.0;     ///< s^2 [u^2]
};

/// Averages over `size` samples each, one after the other, of the samples that were measured; those of which a tenth or
/// more is missing are skipped.
/// Given: values [u]; size [samples].
AverageScatter scatter_of_averages(std::span<const double> values, std::size_t size);

/// s^2 by a noise model, of averages over `shorter` samples and over `ratio` times as many.
struct ExpectedScatter {
  double shorter = 0.0, longer = 0.0;                    ///< expectation [u^2]
  double shorter_variance = 0.0, longer_variance = 0.0;  ///< of s^2 [u^4]
  double covariance = 0.0;                               ///< between the two s^2 [u^4]
};

/// With V the covariance of the averages (generalised, see generalised_autocovariance) and P the centring matrix,
///
///   E[s^2] = tr(P V)/(M - 1),   Cov(s_1^2, s_2^2) = 2 |P_1 V_12 P_2|^2/((M_1 - 1)(M_2 - 1))   (Frobenius norm)
///
/// Given     terms and their squared coefficients [u^2]; samples in the record
/// Accuracy  exact for Gaussian noise; beyond 4000 averages the covariances of 4000 are scaled by 4000/M
ExpectedScatter expected_scatter(const std::vector<UnitTerm>& terms, const std::vector<double>& squared,
                                 std::size_t samples, std::size_t shorter, std::size_t ratio);

/// Variance of the mean of the first n samples after power-on about the constant at power-on, for the unit terms:
///
///   2/n^2 (quantization),  1/n (white),  n/3 (random walk from zero at power-on),
///   2 sd^2 (r - 1 + exp(-r))/r^2, r = n/T_c, summed over the bank (flicker, from T/4 to beyond four records: what is
///   slower belongs to the bias itself)
/// Returned: variance [1], of a squared coefficient of one.
double mean_variance(const UnitTerm& term, std::size_t samples);

/// By how much the steps of an output may move its mean [u], an sd: rounding, as far as noise does not even it out; and half a step
/// to either side where the steps exceed the noise, since values that were cut off look like rounded ones.
double steps_move_mean(std::span<const double> values);

}  // namespace tumble::static_bias
