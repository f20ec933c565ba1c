#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// Power-law noise S_y(f) ~ f^alpha of a frequency (rate) signal: 2 white phase (quantization), 1 flicker phase, 0
/// white rate (random walk of the angle), -1 flicker rate (bias instability), -2 rate random walk, -3 and below: drift.
struct DeviationPoint {
  std::size_t factor = 0;  ///< m, averaging factor
  double tau = 0.0;        ///< [s]
  double deviation = 0.0;  ///< [u]
  std::size_t count = 0;   ///< number of terms summed
  int alpha = 0;           ///< noise type identified at this tau
  double edf = 0.0;        ///< equivalent degrees of freedom of the variance
  double lower = 0.0;      ///< confidence limits of the deviation [u]
  double upper = 0.0;
};

struct AllanOptions {
  double points_per_decade = 10.0;     ///< of tau, as averaging_factors takes them; 0: octaves
  double confidence = 0.95;            ///< two-sided
  double longest_fraction = 0.25;      ///< longest tau as a fraction of the record, at most 0.5
  std::vector<std::size_t> factors{};  ///< averaging factors m, ascending, in place of points_per_decade; empty: those
  bool remove_bias = true;             ///< of the total deviations
  bool subtract_mean_rate = true;      ///< of the record, in interval errors
};

/// Overlapping Allan deviation of a rate signal at log-spaced averaging times, with confidence limits from chi-square
/// with the equivalent degrees of freedom of the noise type found at each tau.
///
///   sigma^2(m t0) = 1/(2 (m t0)^2 (N-2m)) sum_n (x_{n+2m} - 2 x_{n+m} + x_n)^2,   x the running integral, N its length
///
/// Given     rate         signal [u], evenly spaced; sample_rate [Hz], > 0. NaN: missing samples (the terms that need
///                        them are skipped; a factor with no term left is absent from the answer)
/// Throws    Error::bad_data for fewer than 3 samples or an infinite value; Error::bad_input for options out of range
/// Accuracy  1e-10 relative against the direct sum in long double, also beside a large mean or drift
/// See       NIST SP 1065 (2008), eq. (11); noise type: noise_type.hpp; edf: allan_edf.hpp
std::vector<DeviationPoint> overlapping_allan(std::span<const double> rate, double sample_rate,
                                              const AllanOptions& options);

/// Overlapping Allan deviation at given averaging factors, of a record of any length.
///
/// Given     rate         signal [u], as above; sample_rate [Hz]
///           factors      averaging factors m, ascending; confidence [1], two-sided
///           alphas       noise type of each factor where it is known; empty: identified
/// Returned  one point a factor: tau [s], deviation and limits [u]
std::vector<DeviationPoint> overlapping_allan(std::span<const double> rate, double sample_rate,
                                              std::span<const std::size_t> factors, double confidence,
                                              std::span<const int> alphas = {});

/// Distinct averaging factors 1, ..., longest: the same steps in every octave, as many as come nearest to
/// points_per_decade and at least one (octaves, also for 0). From 16 on they are multiples of powers of two, and the
/// double of each is one of them, which lag_sums is quick with (docs/decisions/033).
///
/// Given     longest [samples], points_per_decade [1]
/// Returned  averaging factors [samples], ascending
std::vector<std::size_t> averaging_factors(std::size_t longest, double points_per_decade);

/// Limits of a deviation whose variance has a chi-square distribution: lower = deviation sqrt(edf/chi2((1+p)/2)), upper
/// the same with (1-p)/2.
struct Limits {
  double lower = 0.0;  ///< [u]
  double upper = 0.0;  ///< [u]
};
/// Given     deviation [u]; edf, degrees of freedom of its square [1]; confidence p [1], two-sided
/// Returned  limits [u]
Limits deviation_limits(double deviation, double edf, double confidence);

}  // namespace tumble
