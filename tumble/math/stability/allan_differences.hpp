#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan_phase.hpp"

namespace tumble {

/// sum_n (x_{n+2m} - 2 x_{n+m} + x_n)^2 over every run, one sum a factor. Works through the phase block by block, so
/// that a block serves many factors while it is in the cache; on all threads where the record is long.
/// Given     phase x [u samples]; factors m [samples]
/// Returned  one sum a factor [u^2 samples^2]
std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors);

/// Adds the sums of squared second differences of one run without gaps.
///
/// Given     x        phase [u samples]; factors m [samples]
///           sums     one a factor [u^2 samples^2]; those of this run are added
void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums);

/// sum (x_{n+2m} - 2 x_{n+m} + x_n)^2 over n < count.
/// Given     x  phase [u samples], count + 2 factor values; factor m [samples]; count, number of terms
/// Returned  sum [u^2 samples^2]
double second_difference_squares(const double* x, std::size_t factor, std::size_t count);

}  // namespace tumble
