#pragma once

#include <span>
#include <vector>

namespace tumble {

/// A signal and its derivatives from a quadratic fitted around each sample.
struct Smoothed {
  std::vector<double> value;      ///< [u]
  std::vector<double> slope;      ///< [u/s]
  std::vector<double> curvature;  ///< second derivative [u/s^2]
};

/// Local quadratic least squares (Savitzky and Golay, 1964) over time +- half_width. At the ends and where samples are
/// missing the quadratic is fitted to those there are; where they are fewer than three, to those within twice the
/// width. Never differentiate raw readings of quantum q: over a span W the error of a difference is q/(sqrt(6) W).
///
/// Given     time [s], increasing, n; signal [u], n, NaN where missing; half_width [s]
/// Returned  n each; NaN where there are still fewer than 3 samples
Smoothed local_quadratic(std::span<const double> time, std::span<const double> signal, double half_width);

}  // namespace tumble
