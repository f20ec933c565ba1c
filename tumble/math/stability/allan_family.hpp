#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_phase.hpp"

namespace tumble {

/// The measures of stability of NIST SP 1065 (2008). x phase (angle or velocity), N points; y rate.
enum class Stability {
  allan,                 ///< ADEV   second difference, terms tau apart
  overlapping_allan,     ///< OADEV  terms one sample apart
  modified_allan,        ///< MDEV   of phase averaged over tau
  time,                  ///< TDEV   = tau MDEV/sqrt(3)
  hadamard,              ///< HDEV   third difference: blind to a rate ramp
  overlapping_hadamard,  ///< OHDEV
  total,                 ///< TOTDEV    of phase extended at both ends by inverted reflection
  modified_total,        ///< MTOTDEV   of each 3 tau of phase, without its slope, extended by reflection
  time_total,            ///< TTOTDEV = tau MTOTDEV/sqrt(3)
  hadamard_total,        ///< HTOTDEV   of each 3 tau of rate, without its slope, extended by reflection
  parabolic,             ///< PDEV   of slopes fitted to phase over tau, two tau side by side
  theo1,                 ///< Theo1     even m from 10; tau = 0.75 m t0; with its own bias against Allan
  theoh,                 ///< TheoH     overlapping Allan up to a tenth of the record, beyond it bias-removed Theo1
  peak_interval_error,   ///< MTIE      largest peak-to-peak phase in any window of m + 1 points
  rms_interval_error     ///< TIE rms of x_{n+m} - x_n
};

struct StabilityOptions {
  double confidence = 0.95;  ///< two-sided
  std::optional<int> alpha;  ///< noise type; identified at each factor when absent
  std::vector<int> types{};  ///< or one for each factor
  bool remove_bias = true;   ///< of the total deviations, against the deviation whose name they bear
};

/// A stability measure of phase data at the given averaging factors.
///
/// With sums over all n that the record has, z2_n = x_{n+2m} - 2 x_{n+m} + x_n, z3_n = x_{n+3m} - 3 x_{n+2m} +
/// 3 x_{n+m} - x_n, tau = m t0, M the number of terms:
///
///   Allan           1/(2 tau^2 M) sum z2_n^2,  n = 0, m, 2m ... or, overlapping, 0, 1, 2 ...            (7), (11)
///   modified Allan  1/(2 tau^2 m^2 M) sum_j (sum_{n=j}^{j+m-1} z2_n)^2                                 (14)
///   Hadamard        1/(6 tau^2 M) sum z3_n^2                                                           (18), (20)
///   total           1/(2 tau^2 (N-2)) sum_{n=1}^{N-2} (x*_{n-m} - 2 x_n + x*_{n+m})^2                  (25)
///   modified total  1/(2 tau^2 M) sum_n 1/(6m) sum_{j=0}^{6m-1} (zbar_j)^2, zbar of segment n          (27)
///   Hadamard total  1/(6 M) sum_n 1/(6m) sum_{j=0}^{6m-1} (zbar_j)^2, the same of the rate
///   parabolic       72/(m^4 tau^2 M) sum_i (sum_{k=0}^{m-1} ((m-1)/2 - k) (x_{i+k} - x_{i+k+m}))^2,  Allan at m = 1
///   Theo1           1/(0.75 tau^2 (N-m)) sum_{i=0}^{N-m-1} sum_{k=0}^{m/2-1} z_ik^2/(m/2-k),           (30)
///                   z_ik = x_i - x_{i-k+m/2} + x_{i+m} - x_{i+k+m/2};  (equation) of NIST SP 1065
///
/// ThêoH at tau = m t0 is the overlapping Allan variance up to N/10, and beyond, for m that 3 divides, up to 3/4 of the
/// record, ThêoBR = b Theo1(4m/3), b the mean of Allan(9 + 3i)/Theo1(12 + 4i) over i = 0 ... n, n = floor(N/30 - 3)
/// (over 64 of these i, evenly, where there are more). It reads the Allan deviation off further than that reaches.
/// Under phase noise the ratio falls with m; `remove_bias` then takes the fall from the known noise type
/// (theo_ratio_change). What bias is left: allan_theoh_test.cpp, 3 % of the variance and less.
///
/// (parabolic: Vernotte, Lenczner, Bourgeois and Rubiola, IEEE Trans. UFFC 63 (2016) 611; ThêoH: D. A. Howe, J.
/// McGee-Taylor and T. Tasset, ThêoH bias-removal method, IEEE Freq. Contr. Symp. 2006, 788; n: J. A. Taylor and D. A.
/// Howe, Fast TheoBR, IEEE Trans. UFFC 57 (2010) 2079)
///
/// edf: Greenhall and Riley (2003) for the differences and TIE rms of phase noise; total deviations, Theo1 and ThêoBR:
/// allan_edf_extended.hpp. edf is 0 and the limits equal the deviation for three measures without one: MTIE (a maximum
/// grows with the record), TIE rms of rate noise (its mean square depends on the reference rate and the record), total
/// under phase noise beyond half the record. In noise of a known type, 95 % limits hold the truth in 93 to 98 % of
/// records of 200 samples, at every tau; from edf 2 on they are a little wide, for the sum is no chi-square.
///
/// Given     phase     x [u s], evenly spaced, no gaps; interval  t0 [s], > 0
///           factors   m, ascending. Those that the record is too short for are absent from the answer
/// Throws    Error::bad_data for values that are not finite; Error::bad_input for the rest
/// Accuracy  NIST 1000-point set to its 7 printed digits; Stable32 tables to their 5 (1e-4)
std::vector<DeviationPoint> stability(Stability measure, std::span<const double> phase, double interval,
                                      std::span<const std::size_t> factors, const StabilityOptions& options);

/// A stability measure of a rate signal [u] in which samples may be missing (NaN). Nothing is put in their place: the
/// runs between them are measured apart and pooled by their numbers of terms, edf likewise; MTIE is the largest of any
/// run.
std::vector<DeviationPoint> stability_of_rate(Stability measure, std::span<const double> rate, double interval,
                                              std::span<const std::size_t> factors, const StabilityOptions& options);

/// A stability measure of phase [u s] with runs between gaps; interval t0 [s], factors m [samples].
std::vector<DeviationPoint> stability_of_runs(Stability measure, const Phase& phase, double interval,
                                              std::span<const std::size_t> factors, const StabilityOptions& options);

/// x_0 = 0, x_{n+1} = x_n + (y_n - mean y) t0, whose stability in all measures but the interval errors is that of y.
/// Given     rate y [u], N values; interval t0 [s]
/// Returned  phase x [u s], N + 1 values
std::vector<double> phase_from_rate(std::span<const double> rate, double interval);

}  // namespace tumble
