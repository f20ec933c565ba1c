#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// How signals go on about one of evenly spaced steps.
enum class StepCourse : char {
  smooth,       ///< no kink within two steps
  beside_kink,  ///< a kink is near, but not here
  from_before,  ///< a kink right after it
  from_after,   ///< a kink right before it
  kinked,       ///< within it
  first,        ///< one of the first two, and no kink near
  last,         ///< one of the last two, and no kink near
};

/// Steps beside one on which its course and its mean rest.
inline constexpr std::size_t step_margin = 4;

/// The course of several signals together, so that what is linear in them has one. A kink is where the second
/// difference is four times as large as two steps before and two steps after: the slope jumps, as where a drive stops
/// to accelerate.
///
/// Given     signals  values in the middle of each step [any, of comparable size]
/// Returned  one for each step
std::vector<StepCourse> courses_of(std::span<const std::array<double, 6>> signals);

/// Means over evenly spaced steps of a signal, from its values in the middle of each, by a formula linear in these:
///
///   mean = v + d2/24 - 17 d4/5760
///
/// with the central differences d2 and d4, d2 alone beside a kink. Right before and after a kink d2 is extrapolated
/// from the side without a kink; in a kink the mean is the value itself. What begins and ends at rest keeps its sum.
///
/// Given     middles  values [u]: `before` in front of the first step, one for each step, and any number after it
///           courses  one for each value of `middles`
///           before   [1]
/// Returned  means    [u], one for each step
/// Accuracy  a sine of frequency w and steps of h: (w h)^6/2640 of its amplitude; beside a kink and at the ends (w
/// h)^4/8
void means_from_middles(std::span<const double> middles, std::span<const StepCourse> courses, std::size_t before,
                        std::span<double> means);

}  // namespace tumble
