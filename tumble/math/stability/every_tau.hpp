#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// Element k belongs to averaging factor m = k + 1.
struct EveryTau {
  std::vector<double> deviation;   ///< [u]
  std::vector<std::size_t> count;  ///< terms summed; 0 (and deviation 0) where gaps leave none
  std::vector<double> rounding;    ///< bound of the relative rounding error of the deviation, 1e-10 unless it is more
};

/// Overlapping Allan deviation of a rate signal at every averaging factor m = 1 ... N/2, exactly as `overlapping_allan`
/// defines it, in O(N log^2 N) instead of O(N^2).
///
///   sum_n (x_n - 2 x_{n+m} + x_{n+2m})^2 = Q(0, N-2m) + 4 Q(m, N-m) + Q(2m, N) + 2 R(2m) - 8 R(m) + 4 H(m) + 4 G(m)
///
/// with N phase points x, Q(a, b) the sum of squares over a <= n < b, and R, H, G as of `lagged_products`. Before, the
/// least-squares quadratic is subtracted, its part is put back in closed form. Where rounding of this sum of large
/// numbers may exceed 1e-10, it is done on short pieces of the record, each less its own quadratic; what is then left
/// is summed directly.
///
/// Given     rate  [u], evenly spaced; NaN: missing samples
/// Throws    Error::bad_data as of overlapping_allan
/// Accuracy  `rounding`, beside the phase's own (white noise to random walk with drift: 1e-10 at every m)
EveryTau every_overlapping_allan(std::span<const double> rate);

/// Overlapping Hadamard deviation in the same way, at m = 1 ... N/3:
///
///   sum_n (x_{n+3m} - 3 x_{n+2m} + 3 x_{n+m} - x_n)^2 = Q(0, N-3m) + 9 Q(m, N-2m) + 9 Q(2m, N-m) + Q(3m, N) - 30 R(m)
///     + 12 R(2m) - 2 R(3m) + 18 (one + one') + 6 (two + two') - 6 (half + half'),
///
/// less the least-squares cubic; primes: of the series read backwards; R, one, two, half as of `third_products`.
///
/// Given     rate  [u], evenly spaced; NaN: missing samples
/// Returned  deviation [u] of every m
/// See       NIST SP 1065 (2008), eq. (20)
EveryTau every_overlapping_hadamard(std::span<const double> rate);

/// Sums of squared differences of order 2 or 3 of phase without gaps, for m = 1 ... (N-1)/order, and the bounds of
/// their relative rounding errors.
/// Given     phase [u samples], N values; order 2 or 3
/// Returned  sums [u^2 samples^2], element k of factor m = k + 1; rounding [1], likewise
std::vector<double> every_difference_sum(std::span<const double> phase, std::size_t order,
                                         std::vector<double>& rounding);

}  // namespace tumble
