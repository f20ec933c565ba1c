#include "tumble/formats/file/plain_value.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <cmath>

#include "tumble/formats/csv/number.hpp"

namespace tumble::file {

namespace {

/// floor(log10(|value|)) for a finite value other than zero; at the powers of ten one less or more would do as well.
int decade(double value) {
  const double estimate = 0.30102999566398120 * std::ilogb(value);
  const int low = static_cast<int>(std::floor(estimate));
  double power = 0.0;
  csv::detail::scaled(1, low + 1, power);
  return std::abs(value) >= power ? low + 1 : low;
}

/// `value` rounded to a multiple of 10^-places, at most 15 digits: the double nearest to that decimal.
double rounded(double value, int places) {
  double scale = 0.0, result = value;
  if (!csv::detail::scaled(1, places, scale)) return value;
  const double digits = std::nearbyint(std::abs(value) * scale);
  if (!(digits <= 1e15) || !csv::detail::scaled(static_cast<std::uint64_t>(digits), -places, result)) return value;
  return std::copysign(result, value);
}

std::size_t length(double value) {
  char text[32];
  return static_cast<std::size_t>(fmt::format_to(text, FMT_COMPILE("{}"), value) - text);
}

/// Of the doubles around `value` that convert back: there are more than one where the product rounds them together.
double shortest_near(double value, double value_si, const Unit& unit) {
  double near[5] = {value, std::nextafter(value, -INFINITY), std::nextafter(value, INFINITY)};
  near[3] = std::nextafter(near[1], -INFINITY);
  near[4] = std::nextafter(near[2], INFINITY);
  const double* best = nullptr;
  std::size_t best_length = 0;
  for (const double& candidate : near) {
    if (unit.to_si(candidate) != value_si) continue;
    if (best != nullptr && best_length == 0) best_length = length(*best);
    const std::size_t candidate_length = best == nullptr ? 0 : length(candidate);
    if (best != nullptr && candidate_length >= best_length) continue;
    best = &candidate;
    best_length = candidate_length;
  }
  return best == nullptr ? value : *best;
}

}  // namespace

double plain_value(double value_si, const Unit& unit) {
  const double value = unit.from_si(value_si);
  if (!std::isfinite(value) || value == 0.0) return value;
  if (unit.offset() == 0.0 && unit.factor() == 1.0) return value;
  if (unit.offset() != 0.0) {  // the sum has lost digits: what was read has rarely more than twelve places
    const double decimal = rounded(value, 12);
    if (unit.to_si(decimal) == value_si) return decimal;
  }
  const double decimal = rounded(value, 14 - decade(value));
  return unit.to_si(decimal) == value_si ? decimal : shortest_near(value, value_si, unit);
}

}  // namespace tumble::file
