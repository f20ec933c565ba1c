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
    1.5;                      ///< [steps between the two smallest sizes] the next value: zero is a step of the output
constexpr double edge = 0.5;  ///< [sd of a sample] beyond the value nearest to zero
constexpr double fewest_at_edge = 40.0;  ///< values that a dead band would leave there, so that their absence tells
constexpr double least_at_edge = 0.05;   ///< [1] of these: fewer are the end of a distribution, and no band cuts it
constexpr double least_between = 0.3;    ///< [1] of the samples, that stand between those of a slower sensor
constexpr double jitter = 1.0;           ///< [samples] of two clocks against one another
constexpr double far_from_zero = 5.0;    ///< [sd of a sample] of all others: zero is no value of such an output

/// The other values, as they lie to zero.
struct OtherValues {
  std::size_t zeros = 0, count = 0, near = 0;
  double sd = 0.0;                               ///< [u] of a sample, by the differences of neighbours
  double nearest = INFINITY, second = INFINITY;  ///< [u] the two smallest sizes
  std::size_t at_edge = 0;                       ///< within `edge` of the nearest
};

void look_at_sizes(std::span<const double> values, OtherValues& others) {
  for (const double value : values) {
    const double size = std::abs(value);
    if (value == 0.0 || std::isnan(value)) continue;
    if (size < others.nearest)
      others.second = std::exchange(others.nearest, size);
    else if (size > others.nearest)
      others.second = std::min(others.second, size);
    if (size < near_zero * others.sd) ++others.near;
  }
  for (const double value : values)
    others.at_edge += value != 0.0 && std::abs(value) <= others.nearest + edge * others.sd;
}

OtherValues other_values(std::span<const double> values) {
  OtherValues others;
  double squares = 0.0, before = std::nan("");
  for (const double value : values) {
    if (value == 0.0) ++others.zeros;
    if (value == 0.0 || std::isnan(value)) continue;
    if (!std::isnan(before)) squares += (value - before) * (value - before), ++others.count;
    before = value;
  }
  if (others.zeros < fewest_zeros || others.count < fewest_zeros) return others;
  others.sd = std::sqrt(0.5 * squares / static_cast<double>(others.count));
  look_at_sizes(values, others);
  return others;
}

/// Whether a dead band that holds so many values would leave far more of them beside it.
bool is_no_band(const OtherValues& others) {
  const double expected = static_cast<double>(others.zeros) * edge * others.sd / others.nearest;
  return expected >= fewest_at_edge && static_cast<double>(others.at_edge) < least_at_edge * expected;
}

bool are_no_values(const OtherValues& others, bool even) {
  if (others.zeros < fewest_zeros || others.count < fewest_zeros) return false;
  if (others.near >= fewest_near_zero) return others.nearest < least_near_zero * near_zero * others.sd;
  if (others.count <= others.zeros && !even) return false;  // an output that rests, or steps beyond the noise
  const bool far =
      others.nearest > far_from_zero * others.sd && others.nearest > step_beside * (others.second - others.nearest);
  return far || is_no_band(others);
}

/// Whether zeros and other values alternate as those of two clocks do: no run of either is longer than its share allows.
bool alternate(std::span<const double> values, double share) {
  const auto longest_of = [&](bool zeros) {
    std::size_t longest = 0, run = 0;
    for (const double value : values) longest = std::max(longest, run = (value == 0.0) == zeros ? run + 1 : 0);
    return static_cast<double>(longest);
  };
  return longest_of(true) <= std::ceil(share / (1.0 - share)) + jitter &&
         longest_of(false) <= std::ceil((1.0 - share) / share) + jitter;
}

}  // namespace

Findings take_zeros_out(EvenSignal& signal, const std::string& label) {
  const OtherValues others = other_values(signal.values);
  const double share = static_cast<double>(others.zeros) / static_cast<double>(signal.values.size());
  const bool between = share > least_between && alternate(signal.values, share);
  if (!are_no_values(others, between)) return {};
  const auto first = static_cast<std::size_t>(std::ranges::find(signal.values, 0.0) - signal.values.begin());
  const Place from(signal.begin + static_cast<double>(first) / signal.rate);
  std::vector<double> made(signal.values.begin(), signal.values.end());
  if (between) {
    std::erase(made, 0.0);
    signal.rate *= 1.0 - share;
  } else {
    std::ranges::replace(made, 0.0, std::nan(""));
  }
  signal.made = std::move(made);
  signal.values = signal.made;
  signal.extremes = extremes_of(signal.values);
  return {{Finding::Severity::warning,
           between ? "zeros_between_samples" : "zeros_not_used",
           {{"part", share, "%"}, {"rate", signal.rate, "Hz"}},
           label,
           {others.zeros, from, {}}}};
}

}  // namespace tumble
