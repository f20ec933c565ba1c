#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tumble {

/// How signals go on about one of evenly spaced steps.
enum class StepCourse : char {
  smooth,       ///< as on both sides of it
  from_before,  ///< as before it
  from_after,   ///< as after it
  kinked,       ///< as on neither side
};

/// Steps beside one on which its course and its mean rest.
inline constexpr std::size_t step_margin = 4;

/// The course of several signals together, so that what is linear in them has one. Beside a kink the central
/// differences are alike: |d4| > |d2|/2, where a sine of phase x a step has d4 = -x^2 d2.
///
/// Given     signals  values in the middle of each step [any, of comparable size]
/// Returned  one for each step; those within two of an end are not smooth
std::vector<StepCourse> courses_of(std::span<const std::array<double, 6>> signals);

/// Means over evenly spaced steps of a signal, from its values in the middle of each, by a formula linear in these:
///
///   mean = v + d2/24 - 17 d4/5760
///
/// with the central differences d2 and d4 where the course is smooth, extrapolated from the side that is smooth where
/// there is one; else the mean is the value itself.
///
/// Given     middles  values [u]: `before` in front of the first step, one for each step, and any number after it
///           courses  one for each value of `middles`
///           before   [1]
/// Returned  means    [u], one for each step
/// Accuracy  a sine of frequency w and steps of h: (w h)^6/2640 of its amplitude; extrapolated (w h)^4/24
void means_from_middles(std::span<const double> middles, std::span<const StepCourse> courses, std::size_t before,
                        std::span<double> means);

}  // namespace tumble
