#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tumble/math/stability/allan_phase.hpp"

namespace tumble {

/// sum_n (x_{n+2m} - 2 x_{n+m} + x_n)^2 over every run, one sum a factor. Works through the phase block by block, so
/// that a block serves many factors while it is in the cache; on all threads where the record is long.
std::vector<double> second_difference_sums(const Phase& phase, std::span<const std::size_t> factors);

/// The same of one run, added to `sums`.
void add_second_differences(std::span<const double> x, std::span<const std::size_t> factors, std::span<double> sums);

/// sum (x_{n+2m} - 2 x_{n+m} + x_n)^2 over n < count.
double second_difference_squares(const double* x, std::size_t factor, std::size_t count);

}  // namespace tumble
