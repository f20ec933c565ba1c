#pragma once

#include <cmath>
#include <numbers>

namespace tumble {

/// Standard deviation of the normal distribution over the median of its magnitudes [1].
constexpr double sd_of_median_size = 1.4826;
/// Probability [1] below the upper end of an interval that holds 95 % and misses equally often on both sides.
constexpr double two_sided_95 = 0.975;
/// Probability [1] below the lower end of that interval.
constexpr double below_two_sided_95 = 0.025;
/// Probability [1] below an upper limit that holds 95 %.
constexpr double one_sided_95 = 0.95;
/// Probability [1] that an interval of 95 % misses.
constexpr double missed_by_95 = 0.05;
/// Quantiles of the normal distribution [sd] of two_sided_95 and of one_sided_95, rounded as in tables.
constexpr double normal_two_sided_95 = 1.96, normal_one_sided_95 = 1.645;

/// Probability [1] that a standard normal number is above x [1], with full relative accuracy in the tail.
inline double normal_above(double x) { return 0.5 * std::erfc(x / std::numbers::sqrt2); }

/// Probability [1] that a standard normal number is below x [1], with full relative accuracy in the tail.
inline double normal_below(double x) { return normal_above(-x); }

}  // namespace tumble
