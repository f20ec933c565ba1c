#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::allan_noise {

/// A straight trend of a rate signal, estimated beside its noise.
struct Ramp {
  bool kept = false;
  double slope = 0.0;               ///< [u/s]
  double sd = 0.0;                  ///< [u/s] under the fitted noise, random walk at its limit where none was seen
  double taken = 0.0;               ///< [u^2/s^2] variance of the slope under the fitted noise itself
  double degrees_of_freedom = 0.0;  ///< of sd, whose noise model is itself estimated
  double chance = 1.0;              ///< probability of so much, either way, without a trend
};

/// Slope of y = a + R t by generalised least squares on at most 4096 averages of the record, whitened by the noise
/// model of `fit`. Given: values [u]; NaN: missing; rate [Hz].
Ramp estimate_ramp(std::span<const double> values, double rate, const AllanFit& fit);

/// Unbiased Allan variances of the noise about the slope: those of the record less the line, plus what the line took.
/// With R^ the best linear estimate, tau^2 (R^2 - var R^)/2 is what a true trend adds, so var R^ tau^2/2 goes back.
/// Given: rate [Hz].
std::vector<AllanObservation> without_ramp(std::vector<AllanObservation> observations, double rate, const Ramp& ramp);

/// The record less the line, for its Allan variance. Given: values [u], rate [Hz], slope [u/s]. Returned: [u].
std::vector<double> levelled(std::span<const double> values, double rate, double slope);

}  // namespace tumble::allan_noise
