#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/matrix.hpp"
#include "tumble/math/stability/allan_covariance.hpp"

namespace tumble {

/// One overlapping Allan variance as it was measured.
struct AllanObservation {
  std::size_t factor = 1;
  double variance = 0.0;  ///< [u^2]
  std::size_t count = 0;  ///< differences averaged; 0: all that a record without gaps has
};

struct AllanFitOptions {
  std::vector<NoiseTerm> terms{NoiseTerm::quantization, NoiseTerm::white, NoiseTerm::flicker, NoiseTerm::random_walk};
  double markov_time = 0.0;    ///< above zero: also one Gauss-Markov process of this correlation time [samples]
  bool select = true;          ///< only the terms that the data support; false: all that are positive
  double significance = 0.05;  ///< a term remains if its p-value is below this
};

struct FittedTerm {
  UnitTerm unit;
  bool kept = false;
  double squared = 0.0;             ///< squared coefficient [u^2], see UnitTerm; as tried if not kept
  double squared_sd = 0.0;          ///< under the fitted model if kept, under the model without the term if not
  double z = 0.0;                   ///< squared over its sd under the model without the term
  double improvement = 0.0;         ///< of -2 log likelihood by the term; kept terms only
  double chance = 1.0;              ///< probability of so much if the term were absent, by z or by improvement
  double degrees_of_freedom = 0.0;  ///< for a Student interval of the coefficient itself (the root)
  double upper_limit = 0.0;         ///< of the squared coefficient, 95 % one-sided [u^2]
  double root_correction = 1.0;     ///< by which the root of `squared` is to be multiplied to be unbiased
};

struct AllanFit {
  std::vector<FittedTerm> terms;               ///< everything tried, in the order of the options, then markov
  std::vector<double> squared;                 ///< of every term tried, zero where not kept [u^2]
  Matrix covariance;                           ///< of `squared` [u^4]; with select = false also of those at zero
  std::vector<double> model_error_variance;    ///< the part of its diagonal that comes from model_error [u^4]
  std::vector<double> markov_time_covariance;  ///< of T_c [samples] with `squared`, then its variance; if kept
  std::vector<double> fitted;                  ///< Allan variance of the fitted model at each factor [u^2]
  std::vector<double> residual;                ///< measured over fitted minus one
  std::vector<double> residual_sd;             ///< statistical, of the residual
  double chi_square = 0.0;                     ///< with the statistical covariance alone
  double degrees_of_freedom = 0.0;             ///< of chi_square
  double model_error = 0.0;                 ///< relative sd per factor that the terms miss beyond statistics; 0: none
  double minus_twice_log_likelihood = 0.0;  ///< with the statistical covariance alone, up to a constant
  double condition = 0.0;                   ///< of the whitened design of the kept terms with unit columns
};

/// Squared coefficients of the noise terms from overlapping Allan variances, by generalised least squares with the full
/// covariance between averaging times under the fitted model (iterated), coefficients not below zero.
///
///   E[sigma^2(m)] = 3 c_Q/m^2 + c_N/m + (2 ln 2/pi) c_B + c_K m/3 (+ Markov)
///
/// The weights come from the model and not from the data, whose scatter would pull the fit down. A term is tested
/// against the model without it, where its variance is known best, with a chi-square of the degrees of freedom that
/// carry it. What the terms cannot follow beyond statistics enters the covariance as an independent relative error of
/// each variance, sized so that chi-square equals its degrees of freedom.
///
/// Given     observations  ascending factors, best an octave apart; samples: length of the record
/// Throws    Error::bad_data for fewer than 2 observations or no positive variance
/// See       covariance: allan_covariance.hpp
AllanFit fit_allan(const std::vector<AllanObservation>& observations, std::size_t samples,
                   const AllanFitOptions& options);

/// A fit with one Gauss-Markov process of free correlation time where the record asks for it: tried if the terms
/// alone fit worse than chance does once in 20 records, over correlation times from 1 sample to 1/20 of the record, and
/// kept if -2 log likelihood falls by more than 13.8 (0.1 % of a chi-square of the two parameters). The covariance is
/// linearised in the correlation time.
AllanFit fit_allan_and_markov(const std::vector<AllanObservation>& observations, std::size_t samples,
                              const AllanFitOptions& options);

/// The observations about an octave apart that a fit takes from a finer curve: the last always, and between the others
/// a factor of at least 1.9.
std::vector<AllanObservation> thinned(const std::vector<AllanObservation>& observations);

/// Degrees of freedom for which value +- t sd holds the truth 95 % of the time, where value = sqrt(c), sd by the delta
/// method, and c = P - M with P chi-square distributed with `edf` and c = share of P on average.
/// Given     edf [1]; share [1], between 0 and 1
/// Returned  degrees of freedom [1]
double root_interval_degrees_of_freedom(double edf, double share);

/// P(chi2/edf > ratio) [1], with chi2 of `edf` degrees of freedom [1].
double chi_square_tail(double ratio, double edf);

}  // namespace tumble
