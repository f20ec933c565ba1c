#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tumble/math/random.hpp"

namespace tumble {

/// Variance of the mean of a Markov process over that of the process [1].
/// Given: length of the mean over the correlation time [1].
inline double markov_mean_variance(double length) {
  constexpr double short_length = 1e-3;  // two terms of the series are exact to 1e-7 there; the formula cancels
  return length < short_length ? 1.0 - length / 3.0 : 2.0 * (length + std::expm1(-length)) / (length * length);
}

/// The noise of a rate signal (angular rate or specific force; u is its SI unit), named as in IEEE Std 528. One set of
/// numbers is simulated, expected (as an Allan variance) and used to whiten residuals. Zero: the term is absent.
///
/// Two-sided PSD of each term, f [Hz]: quantization (2 pi f)^2 T Q^2 -> sigma^2 = 3 Q^2/tau^2, random walk N^2,
/// bias instability B^2/(2 pi f), rate random walk K^2/(2 pi f)^2, Markov 2 sd^2 T_c/(1 + (2 pi f T_c)^2).
struct NoiseModel {
  double quantization_noise = 0.0;  ///< Q [u s]
  double angle_random_walk = 0.0;   ///< N [u sqrt(s)]
  double bias_instability = 0.0;    ///< B [u]; flat part of the deviation is 0.664 B
  double rate_random_walk = 0.0;    ///< K [u/sqrt(s)]
  double rate_ramp = 0.0;           ///< R [u/s], deterministic
  double markov_sd = 0.0;           ///< [u]
  double markov_time = 0.0;         ///< T_c [s]
};

/// Expected Allan variance [u^2] at averaging time tau [s]: sum of the terms (exact for the continuous process,
/// averaged over tau).
/// See       docs/equations (6.2), (6.3)
double expected_allan_variance(const NoiseModel& noise, double tau);

/// A first-order Gauss-Markov process of a bank that represents bias instability.
struct MarkovComponent {
  double sd;    ///< [u]
  double time;  ///< correlation time [s]
};

/// Bias instability B as a sum of Markov processes whose times lie a factor 4 apart from `shortest` to beyond
/// `longest` [s]: sd^2 = B^2 ln(4)/pi each, which gives the PSD B^2/(2 pi f) between within 0.3 %: for covariances.
std::vector<MarkovComponent> flicker_bank(double bias_instability, double shortest, double longest);

/// Adds one realisation of the noise to a rate signal of `count` samples, each the mean over its interval
/// 1/sample_rate, block after block: the sum does not depend on how the samples are cut into blocks.
class NoiseSource {
 public:
  /// Given: sample_rate [Hz]; count, samples of the whole record: bias instability is simulated as slow as four records
  NoiseSource(const NoiseModel& noise, double sample_rate, std::size_t count, const RandomStream& random);
  /// Adds the noise [u] to the next samples.
  void add(std::span<double> block);

 private:
  std::vector<std::function<void(std::span<double>)>> parts_;
};

/// Adds noise to a whole record at once. Given: sample_rate [Hz]; signal [u].
void add_noise(const NoiseModel& noise, double sample_rate, const RandomStream& random, std::span<double> signal);

}  // namespace tumble
