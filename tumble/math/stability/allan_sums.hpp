#pragma once

#include <cstddef>
#include <span>

namespace tumble {

/// Mean square of the terms of a stability measure and their number (0: the record is too short). Phase in samples:
/// t0 = 1. Equations at `stability`.
struct MeanSquare {
  double value = 0.0;     ///< [u^2]
  std::size_t count = 0;  ///< number of terms
};

/// Variance of a d-th difference, d = 2 or 3, of terms `stride` samples apart, and the other measures of a phase.
///
/// Given     x       phase [u samples], without gaps; m, averaging factor [samples]
///           order   d; stride [samples]
/// Returned  mean square of the terms [u^2]
MeanSquare difference_variance(std::span<const double> x, std::size_t m, int order, std::size_t stride);
MeanSquare modified_allan_variance(std::span<const double> x, std::size_t m);
MeanSquare parabolic_variance(std::span<const double> x, std::size_t m);
MeanSquare total_variance(std::span<const double> x, std::size_t m);
/// Mean over segments of 3 m values of the mean square of second differences of m-averages, each segment without its
/// slope and extended by reflection on both sides. Of phase: 2 m^2 times the modified total variance. Of rate: 6 times
/// the Hadamard total variance.
///
/// Given     values  phase [u samples] or rate [u]; m [samples]
/// Returned  mean square [values^2]
MeanSquare reflected_segments(std::span<const double> values, std::size_t m);

/// Given     x  phase [u samples], without gaps; m, averaging factor [samples]
/// Returned  mean square of the terms [u^2]; of the interval errors [u^2 samples^2]
MeanSquare theo1_variance(std::span<const double> x, std::size_t m);
MeanSquare peak_interval_error(std::span<const double> x, std::size_t m);  ///< value: the peak, not its square
MeanSquare interval_error_variance(std::span<const double> x, std::size_t m);

}  // namespace tumble
