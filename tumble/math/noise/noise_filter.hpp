#pragma once

#include <span>
#include <string>
#include <vector>

#include "tumble/math/noise/noise_bands.hpp"

namespace tumble {

/// Shape of the filter through which a sensor passes its white noise before it is sampled, at gain one for frequency
/// zero.
enum class FilterShape {
  none,
  first_order,         ///< low pass of one pole, sampled at instants
  first_order_means,   ///< ... averaged over each sampling interval
  second_order,        ///< low pass of two poles, sampled at instants
  second_order_means,  ///< ... averaged over each sampling interval
  mean,                ///< decimation: running mean over some sampling intervals
  mean_of_means,       ///< ... the mean of such means: sinc^2
  third_mean           ///< ... and once more: sinc^3
};

struct NoiseFilter {
  FilterShape shape = FilterShape::none;
  double bandwidth = 0.0;  ///< [cycles a sample] where the power is half of that at frequency zero
  double damping = 0.0;    ///< [1] second order only

  bool given() const { return shape != FilterShape::none; }
  bool two_poles() const { return shape == FilterShape::second_order || shape == FilterShape::second_order_means; }
  /// Parameters that the record determines: none, the bandwidth, or the bandwidth and the damping.
  int parameters() const { return !given() ? 0 : two_poles() ? 2 : 1; }
};

/// Longest running mean of decimation [samples] and least bandwidth [cycles a sample] of poles: what is slower is a
/// Gauss-Markov process.
constexpr double longest_mean = 32.0, least_bandwidth = 0.01;

/// For people: "low pass of first order" and the like.
std::string filter_name(const NoiseFilter& filter);

/// -3 dB bandwidth [cycles a sample] of decimation by running means over `length` [samples].
double bandwidth_of_means(FilterShape shape, double length);

/// Autocovariance at lags 0, 1, ... [samples] of filtered white noise whose density at frequency zero is one; up to the
/// lag from which on it is below 1e-7. Empty without a filter.
std::vector<double> filtered_autocovariance(const NoiseFilter& filter);

/// Density of the sampled noise over that at frequency zero, what folds included; 1 without a filter.
/// Given: frequency [cycles a sample]. Returned: [1].
double power_gain(const NoiseFilter& filter, double frequency);

/// Covariance at a lag of h units of means over `unit` [samples] of a noise with this autocovariance; empty: white.
/// Given: unit [samples], h [units]. Returned: covariance [1], of a density of one.
double mean_covariance(std::span<const double> autocovariance, double unit, int h);

/// Expected mean squares [1] in bands of such noise of density one, with the pattern of missing samples that is there;
/// without a filter those of white noise.
std::vector<double> expected_filtered(std::span<const NoiseBand> bands, const NoiseFilter& filter);

}  // namespace tumble
