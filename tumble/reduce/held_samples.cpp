#include "tumble/reduce/held_samples.hpp"

#include <cmath>
#include <numeric>

namespace tumble {
namespace {

constexpr std::size_t fewest_values = 100;  ///< of the sensor
/// [1] of the places at which a new value may come, where one does: the noise of a sensor hardly gives one value twice.
constexpr double least_changes = 0.9;

/// Values that stand equally often, one behind the other.
struct Held {
  std::size_t first = 0;  ///< sample at which a value begins
  std::size_t times = 1;  ///< samples of each value
};

Held held_in(std::span<const double> values) {
  Held held;
  std::size_t changes = 0, distance = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] == values[i - 1]) continue;
    if (changes++ == 0) held.first = i;
    distance = std::gcd(distance, i - held.first);
    if (distance == 1) return {};
  }
  if (changes < fewest_values) return {};
  const double places = static_cast<double>((values.size() - held.first) / distance);
  if (static_cast<double>(changes) < least_changes * places) return {};
  held.times = distance;
  held.first %= distance;
  return held;
}

}  // namespace

Findings take_repeats_out(EvenSignal& signal, const std::string& label) {
  const Held held = held_in(signal.values);
  if (held.times < 2) return {};
  std::vector<double> made;
  for (std::size_t i = held.first; i < signal.values.size(); i += held.times) made.push_back(signal.values[i]);
  signal.begin += static_cast<double>(held.first) / signal.rate;
  signal.rate /= static_cast<double>(held.times);
  signal.made = std::move(made);
  signal.values = signal.made;
  signal.extremes = extremes_of(signal.values);
  return {{Finding::Severity::info, "repeats_not_used", {{"times", held.times}, {"rate", signal.rate, "Hz"}}, label}};
}

}  // namespace tumble
