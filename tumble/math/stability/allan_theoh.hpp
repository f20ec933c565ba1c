#pragma once

#include <cstddef>
#include <span>

#include "tumble/math/stability/allan_sums.hpp"

namespace tumble {

/// Records T/tau from this ratio on give the Allan variance itself.
constexpr double theoh_shortest_ratio = 10.0;

/// Mean of Allan(9 + 3i)/Theo1(12 + 4i), see Stability::theoh; 0 of a record too short for one.
/// Given: phase x [u samples]. Returned: ratio [1].
double allan_over_theo1(std::span<const double> x);

/// The overlapping Allan variance up to N/10; beyond, `bias` times Theo1 at 4m/3 where 3 divides m.
/// Given     x  phase [u samples]; bias [1]; m [samples]
/// Returned  variance [u^2] and number of terms
MeanSquare theoh_variance(std::span<const double> x, double bias, std::size_t m);

/// E Allan(3m/4)/E Theo1(m) under white (alpha = 2) and flicker (1) phase noise, which falls with m. For m/2 = h: white
/// 1/(1 + 1/2 + ... + 1/h + 1/(2h)).
/// Given: alpha 1 or 2, m [samples]. Returned: ratio [1].
double expected_allan_over_theo1(int alpha, std::size_t m);

/// Ratio of expected_allan_over_theo1() at 4m/3 over its mean over the range of `allan_over_theo1`: the factor by which
/// ThêoBR of phase noise is to be multiplied. 1 for other noise, whose ratio changes by 5 % or less.
/// Given: alpha, points of the phase, m [samples]. Returned: ratio [1].
double theo_ratio_change(int alpha, std::size_t points, std::size_t m);

}  // namespace tumble
