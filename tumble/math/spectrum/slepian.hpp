#pragma once

#include <cstddef>
#include <vector>

namespace tumble {

/// A discrete prolate spheroidal sequence: of all sequences of its length and unit energy that are orthogonal to those
/// before it, the one with the most energy at frequencies below W.
struct SlepianTaper {
  std::vector<double> values;  ///< sum of squares 1; the even ones of positive sum, the odd ones first positive
  double concentration = 0.0;  ///< share of its energy below W
};

/// The first `count` of length N and time-bandwidth N W, from the eigenvectors of the tridiagonal matrix that commutes
/// with the kernel sin(2 pi W (i - j))/(pi (i - j)):
///
///   T_tt = ((N - 1 - 2 t)/2)^2 cos(2 pi W),   T_t,t-1 = t (N - t)/2
///
/// Given     length  N [samples], at least 2; time_bandwidth  N W [1], 0 < N W < N/2; count, at most N
/// Returned  `count` tapers of N values
/// Throws    Error::bad_input outside of that
/// Accuracy  residual of the kernel's eigenproblem 1e-9 (N up to 65536, tested to 4096)
/// See       D. Slepian, Prolate spheroidal wave functions, Fourier analysis, and uncertainty V, Bell Syst. Tech. J. 57
///           (1978) 1371
std::vector<SlepianTaper> slepian_tapers(std::size_t length, double time_bandwidth, std::size_t count);

}  // namespace tumble
