#pragma once

#include <Eigen/Core>
#include <vector>

#include "tumble/math/noise/noise_bands.hpp"

namespace tumble::noise_likelihood {

/// Bands as vectors: mean squares z, each Gamma distributed about its expectation s with `count` degrees of freedom,
///   -2 ln L = sum_b count_b (ln s_b + z_b/s_b),   s = X c,   c >= 0.
/// With a ramp of slope R, z_b is the mean of (x - R a)^2 and the restricted likelihood is meant: R is integrated out.
struct BandData {
  explicit BandData(const NoiseBands& bands);

  Eigen::VectorXd z, count, with_ramp, ramp_square;
  Eigen::VectorXd slow;    ///< 1 for the sines, which alone estimate the ramp: beside a walk the rest repeats them
  Eigen::VectorXd start;   ///< s before any model: z smoothed over frequency
  Eigen::MatrixXd design;  ///< of power_law_terms
  std::vector<NoiseBand> bands;

  /// Expected mean squares [bands] of a process of unit variance with this correlation time [samples].
  Eigen::VectorXd markov(double time) const;
};

struct ScoringFit {
  Eigen::VectorXd c;  ///< squared coefficients [u^2], none below zero
  Eigen::VectorXd s;  ///< expected mean squares
  double minus_twice_log_likelihood = 0.0;
  double slope = 0.0, slope_variance = 0.0;  ///< of the ramp [u a sample]; zero without
};

/// Maximum of the likelihood by Fisher's scoring: least squares of z on X with weights count/(2 s^2), iterated, with
/// steps halved until the likelihood rises. `known` [u^2] is added to the expectations.
///
/// Given     x  one column a term; start  expectations to begin with
/// Accuracy  1e-7 in -2 ln L
ScoringFit fit_by_scoring(const BandData& data, const Eigen::MatrixXd& x, bool ramp, const Eigen::VectorXd& start,
                          const Eigen::VectorXd* known = nullptr);

/// Slope of the ramp and its variance for given expectations.
struct RampFit {
  double slope = 0.0, variance = 0.0;
};
RampFit fit_ramp(const BandData& data, const Eigen::VectorXd& s);

}  // namespace tumble::noise_likelihood
