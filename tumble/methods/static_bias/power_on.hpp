#pragma once

#include <span>
#include <vector>

namespace tumble::static_bias {

/// Averages of one power-up over about a hundredth of it, one after the other from power-on.
struct Blocks {
  double length = 0.0;         ///< of a block [s]
  std::vector<double> means;   ///< [u], 0 where nothing was measured
  std::vector<double> shares;  ///< measured part of each block, 0 to 1
};

/// Given: values [u], NaN: missing; rate [Hz].
Blocks blocks_of(std::span<const double> values, double rate);

/// Variance of the mean of a power-up about its constant at power-on, if the noise were this.
struct NoiseHypothesis {
  double weight = 0.0;            ///< probability, 1 in sum over all
  double white = 0.0;             ///< N^2 [u^2 s]
  double flicker = 0.0;           ///< B^2 [u^2]
  double walk = 0.0;              ///< K^2 [u^2/s]
  std::vector<double> variances;  ///< [u^2], one a power-up
};

/// Possible noise of the power-ups: white noise, bias instability and random walk, on a grid of the ratios of the
/// three, with the level by its restricted likelihood. The ratios weigh alike on a logarithmic scale before the data.
///
///   weight ~ exp(log L(B^2/N^2, K^2/N^2)),   Var(mean) = N^2/T + B^2 g + K^2 T/3,   g by mean_variance()
///
/// A record does not show a random walk that moves its mean by up to three times the white noise. Neither its absence
/// nor its presence is taken for granted: the record decides by how much each hypothesis explains it.
/// Given: power-ups of four blocks or more each.
std::vector<NoiseHypothesis> noise_hypotheses(const std::vector<Blocks>& power_ups);

/// Half width of the 95 % interval of a normal number with the variance of one power-up, over all hypotheses.
/// Given: freedom, degrees of freedom of the level of the noise [1]. Returned: half width [u].
double half_width(const std::vector<NoiseHypothesis>& hypotheses, std::size_t power_up, double freedom);

}  // namespace tumble::static_bias
