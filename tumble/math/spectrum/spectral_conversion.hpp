#pragma once

#include <cstddef>
#include <span>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/stability/allan_family.hpp"

namespace tumble {

/// Squared transfer function from a rate signal sampled at 1/T to a stability variance at averaging factor m, with
/// x = pi f T:
///
///   Allan      2 sin^4(m x)/(m sin x)^2        (continuous: 2 sin^4(pi f tau)/(pi f tau)^2)
///   modified   2 sin^6(m x)/(m sin x)^4
///   Hadamard   8 sin^6(m x)/(3 (m sin x)^2)
///
/// Exact for samples, whatever lies between them: the spectrum is that of the samples, aliases included.
///
/// Given     measure    Allan, modified Allan or Hadamard, overlapping or not
///           frequency  f T [cycles a sample], 0 ... 1/2
/// Throws    Error::unsupported for a measure that is no mean of squared differences of averages
/// See       NIST SP 1065 (2008), 7.5; W. F. Egan in IEEE Std 1139 for the modified one
double stability_transfer(Stability measure, double frequency, std::size_t factor);

/// Stability variance [u^2] of a signal with the one-sided density S(f) [u^2/Hz]: integral of S times the transfer
/// function over the frequencies that are given, and none beyond. Between them S is taken as a power law.
///
/// A spectrum gives each Allan variance, but Allan variances do not give the spectrum: different spectra have the same
/// ones at all tau (Greenhall). Only within a family such as sums of power laws is the way back unique, so it leads
/// through the identified terms: fit_noise, then `sampled_density`.
///
/// Given     frequency [Hz], ascending, above 0 and at most rate/2; density [u^2/Hz], not below 0; rate [Hz]
/// Throws    Error::bad_input where these do not hold
/// Accuracy  1e-9 of the integral of what is given
/// See       C. A. Greenhall, Spectral ambiguity of Allan variance, IEEE Trans. Instrum. Meas. 47 (1998) 623
double stability_variance_from_spectrum(Stability measure, std::span<const double> frequency,
                                        std::span<const double> density, double rate, std::size_t factor);

/// One-sided density [u^2/Hz] of the noise as a continuous signal, twice that of NoiseModel. The ramp has none.
///
/// Given     frequency [Hz], above 0; rate [Hz] of the samples whose rounding is the quantization
double continuous_density(const NoiseModel& noise, double frequency, double rate);

/// One-sided density [u^2/Hz] of its samples, each the mean over an interval 1/rate: sinc^2 of the averaging, and the
/// frequencies beyond rate/2 folded back.
///
///   S(f) = 2 sum_k sinc^2(pi (f + k rate)/rate) S2(f + k rate)
///
/// Given     frequency [Hz], above 0 and at most rate/2
/// Accuracy  1e-6
double sampled_density(const NoiseModel& noise, double frequency, double rate);

}  // namespace tumble
