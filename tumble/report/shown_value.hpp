#pragma once

#include <array>
#include <charconv>
#include <cmath>

#include "tumble/units/unit.hpp"

namespace tumble {

/// Number [1] of characters of the shortest decimal that reads back as the same double.
inline std::size_t decimal_length(double value) {
  std::array<char, 32> text;
  return static_cast<std::size_t>(std::to_chars(text.begin(), text.end(), value).ptr - text.begin());
}

/// The double next to `start` [u] with the shortest decimal that `to_si` takes exactly to `si` [SI]; NaN if no double
/// is.
template <class ToSi>
double exact_near(double start, double si, const ToSi& to_si) {
  double best = NAN;
  double below = start, above = start;
  const auto consider = [&](double candidate) {
    if (to_si(candidate) != si) return;
    if (std::isnan(best) || decimal_length(candidate) < decimal_length(best)) best = candidate;
  };
  consider(start);
  if (!std::isnan(best) && decimal_length(best) <= 15) return best;  // short already
  for (int step = 0; step < 2; ++step) {
    consider(below = std::nextafter(below, -INFINITY));
    consider(above = std::nextafter(above, INFINITY));
  }
  return best;
}

/// `si` [SI] in a displayed unit, such that reading it back gives `si` exactly where a double of the displayed unit
/// can, else the value next to it; either way writing what was read gives the same number again. NaN where no number of
/// the displayed unit is finite.
template <class ToSi, class FromSi>
double shown_value(double si, const ToSi& to_si, const FromSi& from_si) {
  const double start = std::isfinite(si) ? from_si(si) : NAN;
  if (!std::isfinite(start)) return NAN;
  double value = exact_near(start, si, to_si);
  if (std::isnan(value)) value = exact_near(from_si(to_si(start)), to_si(start), to_si);
  return (std::isnan(value) ? start : value) + 0.0;  // no minus before zero: reading it would lose that
}

/// A value [SI] in a unit, as above.
inline double shown_value(double si, const Unit& unit) {
  return shown_value(
      si, [&](double x) { return unit.to_si(x); }, [&](double x) { return unit.from_si(x); });
}

}  // namespace tumble
