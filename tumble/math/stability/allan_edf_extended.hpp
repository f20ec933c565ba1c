#pragma once

#include <cstddef>

namespace tumble {

/// Bias and equivalent degrees of freedom of the variances that extend the record or mix many strides: total, modified
/// total, Hadamard total and Theo1.
///
/// They are quadratic forms v = x' Q x of the phase. For power-law noise with generalised autocovariance S (Greenhall
/// and Riley 2003, eq. (7)-(9)) E v = tr(Q S) and edf = tr(Q S)^2/tr(Q S Q S), which was computed with the full
/// matrices for records of 145 to 481 points; here are tables of the results and of their limits for long records.
///
/// Comparison with NIST SP 1065 (2008), which has values from repetition: table 8 for the bias of the modified total
/// variance (0.94, 0.83, 0.73, 0.70, 0.69), where the matrices give 0.995, 0.851, 0.772, 0.717, 0.679; the Hadamard
/// total one, which is the same two powers of f further on, agrees with the matrices (0.995 ... 0.679). Its edf of
/// these two are up to 40 % larger, and that of Theo1 (Howe and Tasset) becomes negative for random walk beyond 0.6 of
/// the record.
///
/// alpha -4 ... 2, outside of what is named set to the nearest. factor m, ratio (N - 1)/m of N phase points.

/// E total variance/E Allan variance. Exact for alpha = 2, linear in m/T as in SP 1065 table 7 for alpha <= 0.
///
/// Given     alpha; factor m [samples]; ratio (N - 1)/m [1]
/// Returned  ratio of the two variances [1]
double total_bias(int alpha, std::size_t factor, double ratio);
/// E modified total variance/E modified Allan variance, alpha 2 ... -2.
/// Returned: ratio of the two variances [1].
double modified_total_bias(int alpha, std::size_t factor);
/// E Hadamard total variance/E Hadamard variance, alpha 2 ... -4, m > 1.
/// Returned: ratio of the two variances [1].
double hadamard_total_bias(int alpha, std::size_t factor);

/// Equivalent degrees of freedom of the total variances.
///
/// Given     alpha; factor m [samples]; ratio (N - 1)/m [1]
/// Returned  edf [1]
/// Accuracy  5 %; flicker phase noise and m below 8: 12 %. 0: alpha > 0 and tau beyond half the record
double total_edf(int alpha, std::size_t factor, double ratio);
double modified_total_edf(int alpha, std::size_t factor, double ratio);
double hadamard_total_edf(int alpha, std::size_t factor, double ratio);

/// Equivalent degrees of freedom [1] of Theo1 of stride m (tau = 0.75 m t0) in a record of N phase points.
/// Accuracy 12 %.
double theo1_edf(int alpha, std::size_t factor, std::size_t points);

/// Equivalent degrees of freedom [1] of ThêoBR at m: what the ratio, known from the same record, adds to the scatter,
/// from 4000 records of 100, 150 and 300, 3000 of 200 and 600 of 1200 samples (which agree to 10 %).
double theo_bias_removed_edf(int alpha, std::size_t factor, std::size_t points);

}  // namespace tumble
