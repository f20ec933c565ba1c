#pragma once

#include <vector>

namespace tumble {

/// Values by taper, then by frequency.
using ByTaper = std::vector<std::vector<double>>;

/// Weights of the eigenspectra S_a of tapers that leave 1 - lambda_a of their energy beyond the bandwidth, sum over a
/// 1:
///
///   w_a ~ lambda_a b_a^2,   b_a = S/(lambda_a S + (1 - lambda_a) s^2),   S = sum w_a S_a,
///
/// by iteration from the mean of the first two. Where S is small against what a taper lets in from elsewhere, that
/// taper counts little.
///
/// Given     eigenspectra [u^2/Hz]; leaks  1 - lambda_a [1], one a taper
///           level  s^2 [u^2/Hz]: density of white noise of the record's variance
/// Returned  weights [1]
/// See       D. J. Thomson, Proc. IEEE 70 (1982) 1055; D. B. Percival and A. T. Walden, Spectral Analysis for Physical
///           Applications, 1993, section 7.4
ByTaper adaptive_weights(const ByTaper& eigenspectra, const std::vector<double>& leaks, double level);

}  // namespace tumble
