#pragma once

#include <cmath>
#include <cstddef>
#include <utility>

namespace tumble {

/// The greater part of a line that is divided by the golden section [1]: (sqrt(5) - 1)/2.
constexpr double golden_section = 0.6180339887498949;

/// Number k of a sequence that fills [0, 1) evenly and is in step with no period: multiples of the golden section, from
/// `first` [1] on, without their whole part.
///
/// Returned  a fraction in [0, 1) [1]
inline double golden_fraction(std::size_t k, double first) {
  return std::fmod(golden_section * static_cast<double>(k) + first, 1.0);
}

/// Smallest value between a and b of a function with one minimum there, by golden section.
///
/// Given     of    called with a position, returns what is compared; a value need not be a number
///           goes_on  called with the length of the interval [of a] before each step; false ends the search
///           less     whether one value is below another
/// Returned  the two last positions inside of the interval with their values, and the interval that remains
template <class Of, class GoesOn, class Less>
auto golden_section_search(double a, double b, const Of& of, GoesOn goes_on, const Less& less) {
  using Value = decltype(of(a));
  struct Result {
    double a, b;
    Value at_left, at_right;
  };
  double left = b - golden_section * (b - a), right = a + golden_section * (b - a);
  Value at_left = of(left), at_right = of(right);
  while (goes_on(b - a)) {
    if (less(at_left, at_right)) {
      b = right;
      right = left;
      at_right = std::move(at_left);
      at_left = of(left = b - golden_section * (b - a));
    } else {
      a = left;
      left = right;
      at_left = std::move(at_right);
      at_right = of(right = a + golden_section * (b - a));
    }
  }
  return Result{a, b, std::move(at_left), std::move(at_right)};
}

}  // namespace tumble
