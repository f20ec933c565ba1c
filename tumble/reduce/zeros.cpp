#include "tumble/reduce/zeros.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tumble {
namespace {

constexpr std::size_t fewest_zeros = 10;  ///< of an output without steps one is rare
constexpr double near_zero = 0.1;         ///< [sd of a sample] within which values are looked for ...
constexpr std::size_t fewest_near_zero = 20;
constexpr double least_near_zero = 0.2;  ///< ... of which the nearest must be within this part: no step, no dead band
constexpr double step_beside =
    1.5;  ///< [steps between the two smallest sizes] the next value: zero is a step of the output
constexpr double far_from_zero = 5.0;  ///< [sd of a sample] of all others: zero is no value of such an output

bool are_no_values(std::span<const double> values) {
  std::size_t zeros = 0, count = 0, near = 0;
  double squares = 0.0, nearest = INFINITY, before = std::nan("");
  for (const double value : values) {
    if (value == 0.0) ++zeros;
    if (value == 0.0 || std::isnan(value)) continue;
    if (!std::isnan(before)) squares += (value - before) * (value - before), ++count;
    before = value;
  }
  if (zeros < fewest_zeros || count <= zeros) return false;  // mostly zero: a dead band, or steps beyond the noise
  const double sd = std::sqrt(0.5 * squares / static_cast<double>(count));
  double second = INFINITY;
  for (const double value : values) {
    const double size = std::abs(value);
    if (value == 0.0 || std::isnan(value)) continue;
    if (size < nearest)
      second = std::exchange(nearest, size);
    else if (size > nearest)
      second = std::min(second, size);
    if (size < near_zero * sd) ++near;
  }
  if (near >= fewest_near_zero) return nearest < least_near_zero * near_zero * sd;
  return nearest > far_from_zero * sd && nearest > step_beside * (second - nearest);
}

}  // namespace

Findings take_zeros_out(EvenSignal& signal, const std::string& label) {
  if (!are_no_values(signal.values)) return {};
  std::vector<double> made(signal.values.begin(), signal.values.end());
  std::size_t count = 0, first = made.size();
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (made[i] != 0.0) continue;
    made[i] = std::nan("");
    first = std::min(first, i);
    ++count;
  }
  signal.made = std::move(made);
  signal.values = signal.made;
  signal.extremes = extremes_of(signal.values);
  return {{Finding::Severity::warning,
           "zeros_not_used",
           {{"part", static_cast<double>(count) / static_cast<double>(signal.values.size()), "%"}},
           label,
           {count, Place(signal.begin + static_cast<double>(first) / signal.rate), {}}}};
}

}  // namespace tumble
