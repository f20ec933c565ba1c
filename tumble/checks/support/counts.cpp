#include "tumble/checks/support/counts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tumble::support {

bool counts_pulses(const Channel& channel) { return channel.kind == QuantityKind::count; }

Spread spread_of(const Channel& channel) {
  Spread spread{INFINITY, -INFINITY, true};
  std::size_t present = 0;
  for (const double value : channel.values) {
    if (std::isnan(value)) continue;
    if (!std::isfinite(value) || value != std::round(value)) return {0.0, 0.0, false};
    spread.lowest = std::min(spread.lowest, value);
    spread.highest = std::max(spread.highest, value);
    ++present;
  }
  spread.whole = present >= 2;
  return spread;
}

namespace {

/// [steps] that a value may be off a whole number, by the digits of a file.
constexpr double off_a_step = 0.05;

/// Step of sorted values that differ [u]; 0: none. Each difference to the next is a few steps, the whole range many.
double step_of(const std::vector<double>& different) {
  double least = INFINITY, steps = 0.0;
  for (std::size_t i = 1; i < different.size(); ++i) least = std::min(least, different[i] - different[i - 1]);
  for (std::size_t i = 1; i < different.size(); ++i) {
    const double apart = (different[i] - different[i - 1]) / least;
    if (apart < 1e3 && std::abs(apart - std::round(apart)) > off_a_step) return 0.0;
    steps += std::round(apart);
  }
  return (different.back() - different.front()) / steps;
}

}  // namespace

std::vector<double> as_counts(const std::vector<double>& values, std::size_t again_least) {
  std::vector<double> different;
  std::ranges::copy_if(values, std::back_inserter(different), [](double v) { return std::isfinite(v); });
  const std::size_t present = different.size();
  std::ranges::sort(different);
  const auto again = std::ranges::unique(different);
  different.erase(again.begin(), again.end());
  if (different.size() < 2 || present - different.size() < again_least) return {};
  const double step = step_of(different);
  if (!(step > 0.0)) return {};
  std::vector<double> counts;
  for (const double value : values) {
    counts.push_back(std::round(value / step));
    if (std::abs(value / step - counts.back()) > off_a_step) return {};
  }
  return counts;
}

}  // namespace tumble::support
