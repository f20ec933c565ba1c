#pragma once

#include <complex>
#include <span>
#include <vector>

namespace tumble {

/// A frequency response at one frequency, found from a band of the spectra around it.
struct BandResponse {
  double frequency = 0.0;           ///< [Hz]
  std::complex<double> response;    ///< output over input
  double variance = 0.0;            ///< of ln|response|, and of its argument [rad^2]
  double degrees_of_freedom = 0.0;  ///< of the variance
  double coherence = 0.0;           ///< share of the output's power in the band that the input explains
  double input_amplitude = 0.0;     ///< [u] amplitude of a sine with the input's power in the band
  bool found = false;               ///< false: too few lines of the spectra lie around it
};

/// Frequency response under broad-band excitation (a sweep, noise) by the local polynomial method: over the lines k of
/// the two spectra within a band,
///
///   Y_k = (sum_{q<=Q} h_q r^q) X_k + sum_{q<=2} l_q r^q + V_k,   r = (f_k - f)/half width,
///
/// in complex least squares. The second sum takes up what begins before and ends after the record (leakage and
/// transients), so that no window is needed; the scatter of V gives the variance of h_0. Q = 4 where the band has 24
/// lines, else 2; a band with fewer than 11 lines is widened.
///
/// Given     input [u], output [v]  evenly sampled without gaps over the same time T
///           input_rate, output_rate  [Hz]; size/rate must agree
///           frequencies  [Hz] to be looked at; lowest, highest [Hz]: where there is excitation
///           width  half width of the bands as part of their frequency
/// Throws    Error::bad_input for signals of unequal duration
/// Accuracy  bias of the order of the fifth (third) derivative of the response over the band; noise of the input is
///           taken for noise of the output, and lowers |response| by at most 1 - coherence
/// See       Pintelon and Schoukens, System Identification, 2nd ed., 2012: local polynomial method
std::vector<BandResponse> local_polynomial_response(std::span<const double> input, double input_rate,
                                                    std::span<const double> output, double output_rate,
                                                    std::span<const double> frequencies, double lowest, double highest,
                                                    double width);

/// Frequencies [Hz] between which the middle 99 % of the power of an evenly sampled signal lies, its mean subtracted.
std::pair<double, double> occupied_band(std::span<const double> signal, double rate);

/// The greatest number of at most `most` that has no prime factor above 5 and is a multiple of `multiple`: a length
/// for which a Fourier transform is fast. 0: no number fits.
std::size_t smooth_length(std::size_t most, std::size_t multiple);

}  // namespace tumble
