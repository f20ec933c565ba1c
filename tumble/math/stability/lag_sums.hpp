#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// Sums over the first differences d_n = x_{n+m} - x_n of a series of N values at one lag m, n < N - m. They make those
/// of the second differences, because (x_{n+2m} - 2 x_{n+m} + x_n)^2 = 2 d_n^2 + 2 d_{n+m}^2 - (x_{n+2m} - x_n)^2:
///
///   sum_{n<N-2m} (x_{n+2m} - 2 x_{n+m} + x_n)^2 = 2 inner(m) - all(2m)
///
/// If the set of lags is closed under doubling, this is one difference a term instead of two.
struct LagSum {
  double all = 0.0;    ///< sum of d_n^2
  double inner = 0.0;  ///< sum of d_n^2 + d_{n+m}^2 over n < N - 2m
};

/// Whether lag_sums can work a lag out: it is short, or the series is, or it is a multiple of a power of two, a
/// sixteenth of it to a 256th.
bool has_lag_sum(std::size_t size, std::size_t lag);

/// One sum a lag, each below the size of the series and with has_lag_sum; on all threads where the series is long. The
/// result does not depend on their number.
///
/// Given     x [u], N values; lags [samples]
/// Returned  sums [u^2], one a lag
std::vector<LagSum> lag_sums(std::span<const double> x, std::span<const std::size_t> lags);

}  // namespace tumble
