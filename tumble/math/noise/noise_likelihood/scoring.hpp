#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/noise/noise_bands.hpp"
#include "tumble/math/noise/noise_filter.hpp"

namespace tumble::noise_likelihood {

/// Bands as vectors: mean squares z, each Gamma distributed about its expectation s with `count` degrees of freedom,
///   -2 ln L = sum_b count_b (ln s_b + z_b/s_b),   s = X c,   c >= 0,
/// of which only differences between models are used: the values here are less sum_b count_b (1 + ln z_b).
/// With a ramp of slope R, z_b is the mean of (x - R a)^2 and the restricted likelihood is meant: R is integrated out.
struct BandData {
  explicit BandData(const NoiseBands& bands);

  std::vector<double> z, count, with_ramp, ramp_square;
  std::vector<double> slow;   ///< 1 for the sines, which alone estimate the ramp: beside a walk the rest repeats them
  std::vector<double> start;  ///< s before any model: z smoothed over frequency
  Matrix design;              ///< of power_law_terms
  std::vector<NoiseBand> bands;
  std::vector<std::shared_ptr<const PowerScatter>> scatter;  ///< of each scale, along the record

  /// Expected mean squares [bands] of a process of unit variance with this correlation time [samples].
  std::vector<double> markov(double time) const;
  /// Expected mean squares [bands] of filtered white noise of density one.
  std::vector<double> filtered(const NoiseFilter& filter) const;
};

struct ScoringFit {
  std::vector<double> c;  ///< squared coefficients [u^2], none below zero
  std::vector<double> s;  ///< expected mean squares
  double minus_twice_log_likelihood = 0.0;
  double slope = 0.0, slope_variance = 0.0;  ///< of the ramp [u a sample]; zero without
};

/// Maximum of the likelihood by Fisher's scoring: least squares of z on X with weights count/(2 s^2), iterated, with
/// steps halved until the likelihood rises. `known` [u^2] is added to the expectations.
///
/// Given     x  [bands x terms] expected mean squares of unit terms; start [bands] expectations to begin with
///           known  [bands]; empty: nothing
/// Accuracy  1e-9 in -2 ln L
ScoringFit fit_by_scoring(const BandData& data, const Matrix& x, bool ramp, const std::vector<double>& start,
                          std::span<const double> known = {});

/// Roots of the weights count/(2 s^2) of the bands [1/u^2] in least squares.
std::vector<double> root_weights(const BandData& data, std::span<const double> s);

struct RampFit {
  double slope = 0.0, variance = 0.0;
};
/// Slope of the ramp and its variance, given the expectations s [u^2] of the bands.
RampFit fit_ramp(const BandData& data, std::span<const double> s);

}  // namespace tumble::noise_likelihood
