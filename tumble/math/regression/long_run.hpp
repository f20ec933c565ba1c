#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Spectral density of an even series towards zero frequency, two-sided over f [cycles a sample], so that white noise
/// of variance v has density v:
///
///   S(f) = white + blue f^2 + slow/f
///
/// blue: what is bounded when summed up, as the rounding of successive counts and acceleration without a net velocity.
struct DensityAtZero {
  double white = 0.0, blue = 0.0, slow = 0.0;  ///< [u^2]
  Matrix covariance;                           ///< of the three, 3 x 3; zero rows for a part that is not there
  std::size_t ordinates = 0;
};

/// A variance [u^2] and the degrees of freedom it is known with.
struct LongRunVariance {
  double variance = 0.0;
  double degrees_of_freedom = 1.0;
};

/// Weights of sum 1 for the mean of n samples that fade in and out as a cosine over `share` of the series each. A plain
/// mean of band-limited acceleration keeps the velocities at both ends; this one does not. share = 0: 1/n each.
/// Given: share [1], 0 to 1/2. Returned: n weights [1].
std::vector<double> faded_weights(std::size_t n, double share);

/// Variance of sum w_j x_j: white sum w^2 + blue sum (w_j - w_(j-1))^2/(4 pi^2) + slow `slow_gain`, where `slow_gain`
/// is the variance of the same sum for S = 1/f (see slow_gain). Zero densities are raised to a part of their
/// uncertainty.
/// Given: density [u^2]; weights w [1]; slow_gain [1]. Returned: variance [u^2].
LongRunVariance variance_of_sum(const DensityAtZero& density, std::span<const double> weights, double slow_gain = 0.0);

struct LongRun {
  std::vector<DensityAtZero> density;  ///< one a series
  Matrix correlation;                  ///< of the means of the series
};

/// Spectral densities of several series of one length that run side by side. Projections on the sines that vanish at
/// both ends,
///
///   X_k = sqrt(2/n) sum_j (x_j - mean) sin(pi k (j + 1/2)/n),   f = k/(2n),   k = 2, 3, ...
///
/// have variance S(f); the parts of S, none negative, follow by maximum likelihood of X_k^2/S ~ chi-square of one
/// degree of freedom (Whittle). `slow` is taken in where it raises twice the logarithm of the likelihood by 7 or more.
/// The correlation is that of the X_k over sqrt(S) of the lowest frequencies.
///
/// Given     series   n each, missing samples NaN: counted as the mean
///           highest  [cycles a sample] to which S(f) has this form; at least 16 ordinates are used
///           slow     whether slow/f may be there
/// Throws    Error::bad_data for fewer than 64 samples
/// See       K. S. Riedel and A. Sidorenko, Minimum bias multiple taper spectral estimation, 1995 (sine tapers);
///           P. Whittle, The analysis of multiple stationary time series, 1953
LongRun long_run(const std::vector<std::span<const double>>& series, double highest, bool slow);

/// A stretch of time with even weights of sum `weight`.
struct WeightedSpan {
  double begin = 0.0, end = 0.0, weight = 0.0;
};

/// Variance of the sum of the means over stretches times their weights, for noise of two-sided density 1/f; the weights
/// add up to 0, and the unit of time does not matter:  -2 sum_ij w_i w_j <ln|t - s|>, t in i, s in j.
/// Given: spans [any unit of time]. Returned: variance [1].
double slow_gain(std::span<const WeightedSpan> spans);

}  // namespace tumble
