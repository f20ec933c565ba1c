#pragma once

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tumble/math/stability/allan_family.hpp"

/// The statistics of clocks as the package allantools defines them: every factor that has two terms or more, no bias
/// removed, and its `errs`, a deviation over the square root of the number of its terms. This is not an uncertainty: it
/// knows no noise type, and counts terms that overlap as independent.
namespace tumble::python {

/// "octave", "decade", "all", "log10", or averaging times [s].
using Taus = std::variant<std::string, std::vector<double>>;

/// Averaging factors m = round(tau rate), above 0, below `points` and not above `longest`, ascending, each once.
/// Given     rate [Hz]; points, longest [samples]; even: odd factors are skipped
/// Throws    Error::bad_input for another word
std::vector<std::size_t> factors_of(const Taus& taus, double rate, std::size_t points, double longest, bool even);

/// One element a factor that remains.
struct Deviations {
  std::vector<double> taus;   ///< [s]
  std::vector<double> devs;   ///< [u], or [u s] of time deviations and interval errors
  std::vector<double> errs;   ///< as devs
  std::vector<double> ns;     ///< number of terms [1], 2 or more
  std::vector<double> upper;  ///< of gap_robust: upper limits, where errs are the lower ones
};

/// Given     values   phase [u s], or frequency [u] where `of_phase` is false: then missing samples (NaN) at both ends
///                    are skipped, and phase is the integral of the other samples less their mean
///           measure  all but ThêoH. Theo1 is of stride m, and tau is m t0, not 0.75 of it; htotdev at m = 1 is ohdev
///           rate     [Hz]
/// Throws    Error::bad_data for other values that are not finite; Error::bad_input for rates and words that are not
///           accepted
Deviations deviations(Stability measure, std::span<const double> values, double rate, bool of_phase, const Taus& taus);

/// The overlapping Allan deviation of phase with missing points (NaN): terms that all three points have.
/// Given     as above; of frequency phase ends at the first missing sample; ci, alpha (9: none known) as allantools
/// passes
///           them on: in its release 2024.06 ci is taken for the degrees of freedom and these for the probability, so
///           that the limits are NaN unless there are fewer than three degrees of freedom
Deviations gap_robust(std::span<const double> values, double rate, bool of_phase, const Taus& taus, double ci,
                      int alpha);

/// Groslambert codeviation of two phases: root of the size of the mean product of their second differences.
/// Throws    Error::bad_input where the lengths differ
Deviations codeviation(std::span<const double> one, std::span<const double> two, double rate, bool of_phase,
                       const Taus& taus);

}  // namespace tumble::python
