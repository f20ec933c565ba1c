#pragma once

#include <string>
#include <vector>

#include "tumble/math/regression/mixed_model.hpp"
#include "tumble/methods/rlg_lock_in/sweep.hpp"

namespace tumble::rlg_lock_in {

struct DeadBandOptions {
  double margin = 0.05;  ///< of W_L: rates nearer to an edge of the dead band are not used; more where noise is large
  int edges = 1;         ///< counts a fringe
};

/// The beat over the rate, fitted outside of the dead band.
struct DeadBand {
  double scale_factor = 0.0;         ///< size of K [fringe/rad]
  double sense = 1.0;                ///< sign of K; -1: the gyro counts against the rate of the rig
  double bias = 0.0;                 ///< b [rad/s]
  double lock_in_rate = 0.0;         ///< W_L [rad/s]; 0 where all points are dithered
  MixedFit fit;                      ///< of (1/K, b, W_L), without W_L where all points are dithered
  std::vector<bool> used;            ///< a point each
  std::vector<std::string> why_not;  ///< a point each
  std::vector<double> residual;      ///< nominal less fitted rate [rad/s], a point each; NaN in the dead band
  std::vector<std::size_t> rows;     ///< points in the order of the fit's rows
};

/// Fits the points without dither, or all points if all have dither.
///
///   w = sign(f) sqrt((f/K)^2 + W_L^2) - b                                                            from (4.23)
///
/// is the rate at which the gyro beats at f. The residuals are those of the rate. White noise of density N^2 gives the
/// mean over T the variance
///
///   N^2/T (1 + W_L^2/(2 (w + b)^2))                                                                      (4.33)
///
/// which is up to half as much again at the edge; noise of the count enters less and less toward the dead band.
/// A point counts as outside by its nominal rate, |w + b| > (1 + margin) W_L: were it chosen by its beat, those pushed
/// out by noise would stay and those pushed in would not.
///
/// A gyro that counts against the rate of the rig is fitted with its beats reversed, and K is negative.
///
/// Throws  Error::bad_data where the points do not show K, b and W_L
DeadBand fit_dead_band(const Sweep& sweep, const DeadBandOptions& options);

/// The rows of the fit at its values, and the variance of each [rad^2/s^2].
struct BandRows {
  Matrix design;  ///< columns 1/K, b, W_L
  std::vector<double> rates, variances;
};

/// Given  white_variance  [rad^2/s] of the rate noise
BandRows rows_at(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band, double white_variance);

/// White noise of the rate as it shows within the segments, whatever differs between them.
struct NoiseWithin {
  double variance = 0.0;  ///< N^2 [rad^2/s]
  double freedom = 0.0;   ///< degrees of freedom [1]; 0: the segments do not show it
};

/// By the means of eight parts of each segment whose rate is 1.5 times the lock-in rate and more, less what whole pulses
/// make of them.
NoiseWithin noise_within(const Sweep& sweep, const DeadBandOptions& options, const DeadBand& band);

/// Uncertainties of the same fit before the test.
///
/// Given  random_walk  N of the rate noise [rad/sqrt(s)]
DeadBand predict_dead_band(const Sweep& sweep, const DeadBandOptions& options, double scale_factor, double bias,
                           double lock_in_rate, double random_walk);

/// K sign(w + b) sqrt((w + b)^2 - W_L^2), 0 in the dead band [fringe/s].                                  (4.23)
double beat_frequency(const DeadBand& band, double rate);

}  // namespace tumble::rlg_lock_in
