#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// How far two signals fluctuate together at one averaging time.
struct AllanCorrelation {
  std::size_t factor = 0;
  double tau = 0.0;                  ///< [s]
  double correlation = 0.0;          ///< -1 ... 1
  double lower = -1.0, upper = 1.0;  ///< limits
  double chance = 1.0;               ///< probability of so much, either way, of signals that have nothing in common
  double edf = 0.0;
};

/// Correlation of the second differences whose mean squares are the overlapping Allan variances (Groslambert
/// covariance): with v of the signals a and c b, and of their difference, c such that the first are alike at the
/// shortest averaging time,
///
///   r(tau) = (v_a + c^2 v_b - v_d)/(2 c sqrt(v_a v_b))
///
/// Limits by Fisher: atanh r +- z/sqrt(nu - 2), nu = sqrt(nu_a nu_b) of the two variances. By the inequality of Cauchy
/// and Schwarz, nu is not larger than the true one of signals of different noise types, and it is the true one if both
/// are of the same. chance: Student's t with nu - 1 degrees of freedom.
///
/// Given     a, b [any], sampled together; NaN: missing (skipped in both if one lacks it). rate [Hz]; factors ascending
/// Returned  the factors that the record is long enough for (edf above 3)
/// See       Lantz, Calosso, Rubiola, Giordano, Fluhr, Dubois, Vernotte, KLTS: a rigorous method to compute the
///           confidence intervals for the three-cornered hat and for Groslambert covariance, IEEE Trans. UFFC 66 (2019)
std::vector<AllanCorrelation> allan_correlation(std::span<const double> a, std::span<const double> b, double rate,
                                                std::span<const std::size_t> factors, double confidence);

/// The correlation of two signals of several.
struct SignalPair {
  std::size_t a = 0, b = 0;
  std::vector<AllanCorrelation> points;
};
/// Correlations of every pair of signals, (0, 1), (0, 2), ... (1, 2), ...: the variances of a signal are worked out
/// once for all its partners that miss no sample, as it does not itself.
///
/// Given     signals  each [any], of equal length; rate [Hz]; factors m [samples], ascending; confidence [1]
/// Returned  one pair after the other
std::vector<SignalPair> allan_correlations(std::span<const std::span<const double>> signals, double rate,
                                           std::span<const std::size_t> factors, double confidence);

/// Own noise of each of several instruments that measure the same input, at one averaging time.
struct HatPoint {
  struct Instrument {
    double variance = 0.0;            ///< [u^2] of its own noise; below zero where chance has it so
    double lower = 0.0, upper = 0.0;  ///< limits [u^2], not below zero; upper = 0: no variance agrees with the record
  };
  std::size_t factor = 0;
  double tau = 0.0;  ///< [s]
  double edf = 0.0;  ///< least of the differences
  std::vector<Instrument> instruments;
};

/// N-cornered hat: the input that all have in common cancels in the differences d_ij = y_i - y_j of any two,
///
///   s_i^2 = mean over all j < k, none of them i, of cov(d_ij, d_ik),   cov(d_ij, d_ik) = (v_ij + v_ik - v_jk)/2,
///
/// v overlapping Allan variances, all of the same samples, where the three-cornered hat and the Groslambert covariance
/// are the same number. It presumes that the noises have nothing in common, and the same scale factor and alignment.
///
/// Limits: the covariances of d_ij over j are those of a Wishart matrix S of nu degrees of freedom, nu S = L L'. The
/// generalised pivotal quantity L T^-1 T^-T L', T Bartlett's triangle, is drawn 4000 times, always the same; its
/// quantiles, not below zero, are the limits.
///
/// Given     rates  of each instrument [u], sampled together, as above; rate [Hz]; factors ascending
/// Throws    Error::bad_input for fewer than 3 instruments or different lengths; Error::bad_data if two are the same
/// See       J. E. Gray and D. W. Allan, 28th Freq. Contr. Symp. (1974) 243; S. Weerahandi, J. Am. Stat. Assoc. 88
///           (1993) 899 for the intervals
std::vector<HatPoint> three_cornered_hat(std::span<const std::span<const double>> rates, double rate,
                                         std::span<const std::size_t> factors, double confidence);

}  // namespace tumble
