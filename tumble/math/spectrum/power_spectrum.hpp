#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

enum class SpectrumEstimator {
  welch,      ///< Hann windows that overlap by half
  multitaper  ///< 2 NW - 1 Slepian tapers of each segment, segments side by side
};

struct SpectrumOptions {
  std::size_t length =
      0;  ///< of a segment [samples]; 0: a quarter (multitaper: all) of the record, at most 2^20 (2^16)
  double time_bandwidth = 4.0;     ///< NW, multitaper
  double points_per_decade = 0.0;  ///< averaged over bands of frequency, so many a decade; 0: every frequency
  double confidence = 0.95;        ///< two-sided
  bool adaptive = true;            ///< multitaper: tapers weighted at each frequency, not all alike
};

/// One-sided power spectral density [u^2/Hz]: its integral from 0 to half the sampling rate is the variance.
struct PowerSpectrum {
  std::vector<double> frequency;     ///< [Hz], ascending; as far from 0 and from half the rate as the window reaches
  std::vector<double> density;       ///< [u^2/Hz]
  std::vector<double> edf;           ///< equivalent degrees of freedom
  std::vector<double> lower, upper;  ///< limits [u^2/Hz]: density edf/chi2((1 +- p)/2)
  std::size_t length = 0, segments = 0;
  std::size_t left_out = 0;  ///< samples that are there but in no segment: ends of the runs without a gap
  double bandwidth = 0.0;    ///< [Hz] over which one frequency is averaged: 1.5 bins (Hann), 2 W (multitaper)
};

/// Power spectral density of an evenly sampled signal:
///
///   S(f_k) = 2 T/n sum_segments sum_a w_a |sum_t h_a,t (x_t - line) exp(-2 pi i k t/L)|^2/g_ak,   sum_t h_a,t^2 = 1
///
/// Each segment is taken less its least-squares line; g_ak = 1 - |<q_0, h_a e_k>|^2 - |<q_1, h_a e_k>|^2 (q orthonormal
/// polynomials) is what that leaves of white noise, so its level is free of bias at every k. No segment holds a missing
/// sample: each run between gaps has its own. The tapers of a multitaper spectrum have weights w_a of their own at each
/// frequency (power_spectrum_weights.hpp), from all segments: what tapers of high order let in from far frequencies of
/// a steep spectrum is kept out. With edf nu, nu S/E S is taken as chi-square:
///
///   2/nu = mean over all pairs of segments and frequencies averaged of
///          sum_ab w_a w'_b |sum_t h_a,t h_b,t+s exp(-2 pi i (k - l) t/L)|^2
///
/// which is exact for white noise and fixed weights (s: by how much the segments are apart; w': weights of the other
/// frequency) and holds where S does not change over the bandwidth; one frequency: nu = 2 n/sum w_a^2; Welch without
/// averaging: 36 n^2/(19 n - 1).
///
/// Given     values [u]; NaN: missing. rate [Hz]
/// Throws    Error::bad_data if no run is as long as a segment, or of 16 samples, or for an infinite sample;
///           Error::bad_input for options out of range
/// See       P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70; D. J. Thomson, Proc. IEEE 70 (1982) 1055;
///           D. B. Percival and A. T. Walden, Spectral Analysis for Physical Applications, 1993, chapters 6 and 7
PowerSpectrum power_spectrum(SpectrumEstimator estimator, std::span<const double> values, double rate,
                             const SpectrumOptions& options);

}  // namespace tumble
