#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Variance of the logarithm of an amplitude, from which on a tone is below the noise: the sd is a fifth of the
/// amplitude.
constexpr double tone_below_noise = 0.04;
/// [1/span] between a line and another frequency, from which on they disturb each other little. Chosen: beyond the main
/// lobe, which ends at 1.
constexpr double clear_of_line = 1.4;

struct SineFitOptions {
  int harmonics = 1;           ///< lines at f, 2 f, ... harmonics f
  int polynomial = 1;          ///< highest power of time beneath them: 0 offset, 1 and drift
  bool fit_frequency = false;  ///< four parameters: the frequency given is where the search starts
  double rate = 0.0;           ///< [Hz] of even samples; 0: the mean rate of the times. Lines above rate/2 are aliased
};

struct SineFit {
  double frequency = 0.0;                  ///< [Hz]
  double frequency_sd = 0.0;               ///< [Hz]; 0 where it was given
  double centre = 0.0;                     ///< [s] the instant all phases are counted from: middle of the times
  double span = 0.0;                       ///< [s] last time minus first, and one sample
  std::vector<std::complex<double>> line;  ///< a_k [u]: signal = Re sum a_k exp(i 2 pi k f (t - centre)) + polynomial
  std::vector<double> polynomial;          ///< [u] over powers of 2 (t - centre)/span
  Matrix covariance;                       ///< of Re a_1, -Im a_1, Re a_2, ..., the polynomial, and the frequency last
  double noise_variance = 0.0;             ///< [u^2] of a sample, as white noise of the density at f would give it
  double degrees_of_freedom = 0.0;         ///< of noise_variance
  double residual_rms = 0.0;               ///< [u] all that is not fitted, wherever in frequency it lies
  std::size_t samples = 0;

  /// Variance of ln|a_1| and of arg a_1 [1, rad^2].
  double log_gain_variance() const;
  double phase_variance() const;
};

/// Least-squares sine waves of one frequency and its harmonics over a polynomial (the three- and four-parameter fits of
/// IEEE Std 1057, with more lines). Any times: gaps, odd spacing and a broken number of cycles do no harm. A line above
/// half of the sampling rate is fitted at its true frequency.
///
///   x(t) = Re sum_k a_k exp(i 2 pi k f (t - t_c)) + sum_p b_p (2 (t - t_c)/T)^p
///
/// The noise need not be white. Its density at f is taken from the residuals: projections r_m on sine and cosine at
/// f +- m/T, m = 2...11 (within 30 % of f, at least 2...4, as far as they fit between the lines, zero and half of the
/// sampling rate), each made orthogonal to the columns of the fit and of unit norm, so that E r_m^2 is the variance of
/// a sample of white noise of that density. Cov = mean(r_m^2) (X'X)^-1. With fewer than four such projections the
/// residuals are taken as white.
///
/// Given     times [s], increasing, n; values [u], n, NaN where missing; frequency [Hz], > 0
/// Throws    Error::bad_data for fewer than 4 samples above the parameters, a value that is infinite, less than one
///           cycle, a frequency that cannot be distinguished from an offset or its mirror image at these times (near k
///           rate/2), or a four-parameter fit that walks off by more than one cycle over the span
/// See       IEEE Std 1057; noise at a line: var = S1/T with S1 the one-sided density
SineFit fit_sine(std::span<const double> times, std::span<const double> values, double frequency,
                 const SineFitOptions& options);

/// Frequency [Hz] of the highest line of an evenly sampled signal (mean and drift subtracted, Hann window, parabola
/// through the peak): good to a small part of 1/T. Missing samples (NaN) count as the mean.
/// Throws Error::bad_data for fewer than 8 samples or a signal that does not move.
double strongest_frequency(std::span<const double> values, double rate);

/// |f - k rate| for the k that brings it into 0...rate/2: where a line shows in samples taken at `rate` [Hz].
double aliased_frequency(double frequency, double rate);

}  // namespace tumble
