#pragma once

#include <cstddef>
#include <span>

#include "tumble/math/allan_sums.hpp"

namespace tumble {

/// Records T/tau from this ratio on give the Allan variance itself.
constexpr double theoh_shortest_ratio = 10.0;

/// Mean of Allan(9 + 3i)/Theo1(12 + 4i), see Stability::theoh; 0 of a record too short for one.
double allan_over_theo1(std::span<const double> x);

/// The overlapping Allan variance up to N/10; beyond, `bias` times Theo1 at 4m/3 where 3 divides m.
MeanSquare theoh_variance(std::span<const double> x, double bias, std::size_t m);

/// Degrees of freedom of ThêoBR in a record of T/tau = `ratio`; 0 under phase noise.
double theo_bias_removed_edf(int alpha, double ratio);

}  // namespace tumble
