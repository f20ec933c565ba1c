#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// Sums of products of a series with itself `lag` samples later, N values:
///
///   whole[k]    = sum_{i=0}^{N-1-k} x_i x_{i+k}       k = 0 ... 2 M
///   leading[m]  = sum_{i=0}^{m-1}   x_i x_{i+m}       m = 0 ... M
///   trailing[m] = leading[m] of the series read backwards
struct LaggedProducts {
  std::vector<double> whole;
  std::vector<double> leading;
  std::vector<double> trailing;
};

/// All sums in O(N log^2 N): the plane of (i, lag) is cut into squares of 2M/64 or fewer, each a product of short
/// Fourier transforms; the triangles that `leading` leaves on the diagonal are cut likewise, down to direct sums.
///
/// Given     x [u], N values; longest  M, at most N/2
///           threads  whether to use all threads, or only the caller's (for calls from within a thread)
/// Accuracy  absolute, about 2e-16 sum x^2 (tested)
LaggedProducts lagged_products(std::span<const double> x, std::size_t longest, bool threads);

/// Sums of products for third differences, M at most N/3:
///
///   whole as above, k = 0 ... 3 M;      one[m] = sum_{i<m} x_i x_{i+m};      two[m]  = sum_{i<2m} x_i x_{i+m};
///   half[m] = sum_{i<m} x_i x_{i+2m};   m = 0 ... M, and the last three of the series read backwards
struct ThirdProducts {
  struct Ends {
    std::vector<double> one, two, half;
  };
  std::vector<double> whole;
  Ends leading, trailing;
};

/// Sums for third differences, calculated like lagged_products(), with the plane cut along i = 2 lag and i = lag/2 too.
/// Given: x [u], N values; longest M, at most N/3; threads as above. Returned: sums [u^2].
ThirdProducts third_products(std::span<const double> x, std::size_t longest, bool threads);

}  // namespace tumble
