#pragma once

#include <span>
#include <vector>

/// Sine waves of vibration tests: thousands of cycles, dozens of series. A fit as by fit_sine, through normal equations
/// over columns that are nearly orthogonal there, in a few passes.
namespace tumble::sine_vibration {

/// The tone of one series, and the residuals about it.
struct Line {
  double frequency = 0.0;     ///< [Hz]
  double frequency_sd = 0.0;  ///< [Hz]
  double amplitude = 0.0;     ///< [u] of the values, windows and all
  double phase = 0.0;         ///< [rad] in the middle: cosine
  double log_variance = 0.0;  ///< of ln amplitude, by the noise about the line
  double noise_degrees_of_freedom = 1.0;
  double mean = 0.0;                 ///< [u] less tone, harmonics and drift, in the middle
  double drift = 0.0;                ///< [u/s]
  double plain_mean = 0.0;           ///< [u] of the values themselves
  double sd = 0.0;                   ///< [u] of the values themselves
  double second = 0.0, third = 0.0;  ///< [u] amplitude of the harmonics; NaN: hidden by other lines
  double residual_rms = 0.0;         ///< [u]
  double span = 0.0;                 ///< [s] from the first window's beginning to the last one's end
  std::size_t samples = 0;
  std::vector<double> block_mean;     ///< [u] `mean` and the residuals of 16 parts
  std::vector<double> block_seconds;  ///< [s] measured in each
  std::vector<double> residual;       ///< [u] of each value; NaN: missing
};

/// Given     time      [s] middles of windows; value [u], NaN where missing
///           interval  [s] between windows that follow each other
///           frequency [Hz] within about half a cycle over the span; may be above half of the rate
/// Throws    Error::bad_data for fewer than 32 samples or a search that moves away by more than one cycle
/// Accuracy  amplitude, mean and frequency as fit_sine, to 1e-9 of the amplitude
/// See       (3.15); IEEE Std 1057; noise as fit_sine takes it, at f +- m/T, m = 3...12
Line fit_line(std::span<const double> time, std::span<const double> value, double interval, double frequency);

/// A fit without a tone: mean, drift and residuals. Given: time [s], value [u], interval [s].
Line fit_rest(std::span<const double> time, std::span<const double> value, double interval);

}  // namespace tumble::sine_vibration
