#pragma once

#include <cstddef>
#include <vector>

#include "tumble/math/matrix.hpp"

namespace tumble {

/// Terms of the Allan variance whose squared coefficients enter it linearly.
enum class NoiseTerm { quantization, white, flicker, random_walk, markov };

/// A term with a squared coefficient of one when time is counted in samples: c_Q = Q^2/T^2, c_N = N^2/T, c_B = B^2,
/// c_K = K^2 T, c_M = sd^2, all in [u^2].
struct UnitTerm {
  NoiseTerm term = NoiseTerm::white;
  double markov_time = 0.0;  ///< markov only [samples]
};

/// Expected Allan variance of the unit term at averaging factor m: 3/m^2, 1/m, 2 ln 2/pi, m/3.
/// Given     factor  m [samples]
/// Returned  variance [1], of a squared coefficient of one
double unit_allan_variance(const UnitTerm& term, double factor);

/// Derivative of the variance by the correlation time [samples].
double allan_variance_by_markov_time(const UnitTerm& term, double factor);

/// Generalised autocovariance [u^2] of the integral (in samples) of the unit term at a lag in samples: the inverse
/// Fourier transform of its PSD. For white noise -|t|/2, flicker t^2 ln|t|/(2 pi), random walk |t|^3/12. It gives the
/// variance of any combination of values whose weights sum to zero twice over (second differences), and no other.
double generalised_autocovariance(const UnitTerm& term, double lag);

/// Covariances of overlapping Allan variances. For a Gaussian process the second differences d_m of the integral are
/// stationary, and with C_ij(k) = E[d_i(n) d_j(n + k)] and N_m differences at factor m
///
///   Cov(s_i^2, s_j^2) = 2/(N_i N_j) sum_n sum_l C_ij(l - n)^2 / (4 m_i^2 m_j^2).
///
/// C is linear in the squared coefficients, so the covariance is a quadratic form of them: the forms are found once and
/// serve every model tried.
///
/// See       Greenhall and Riley, "Uncertainty of stability variances based on finite differences", PTTI 2003, for the
///           diagonal; the rest by Isserlis' theorem
/// Accuracy  the sums are exact or by 8-point Gauss-Legendre between the kinks of C, good to 1e-3 of the diagonal
class AllanCovariance {
 public:
  /// samples: length of the rate record; factors ascending, each at most samples/2.
  AllanCovariance(std::vector<UnitTerm> terms, std::vector<std::size_t> factors, std::size_t samples);

  /// Covariance matrix [u^4] for squared coefficients `squared` [u^2], one a term.
  Matrix at(const std::vector<double>& squared) const;

  const std::vector<UnitTerm>& terms() const { return terms_; }
  const std::vector<std::size_t>& factors() const { return factors_; }
  /// Expected variances of the unit terms [factors x terms].
  const Matrix& design() const { return design_; }

 private:
  std::vector<UnitTerm> terms_;
  std::vector<std::size_t> factors_;
  Matrix design_;
  std::vector<Matrix> forms_;  ///< of term pairs (t, u <= t), in rows
};

}  // namespace tumble
