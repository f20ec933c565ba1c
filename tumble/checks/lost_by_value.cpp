#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/checks/check.hpp"
#include "tumble/checks/grain.hpp"
#include "tumble/checks/support/each_channel.hpp"
#include "tumble/checks/support/signals.hpp"

namespace tumble::checks::lost_by_value {

namespace {

using namespace support;

/// [1] of the samples that are missing, and number of the gaps, below which nothing is said.
constexpr double least_missing = 0.01;
constexpr std::size_t least_gaps = 20;
/// Values from the greatest one on whose distances tell how a distribution ends. An edge has ten times the distance at
/// the hundredth as at the tenth; the tail of normal noise 1.6 to 2.5 times, of 1000 to a million samples.
constexpr std::size_t near_end = 10, farther = 100;
constexpr double edge = 6.0;  ///< an edge scatters by 3 about 10: a third, that of ten values
/// [1] mean rank of the values beside gaps, from 0 (the lowest) to 1 (the greatest), above which they are the greatest
/// that are left. By chance it is 0.5 with an sd of 0.05 for 20 gaps.
constexpr double greatest_rank = 0.8;

/// How many times as far the hundredth value from the end lies as the tenth, equal ones spread over a step.
double end_of(const std::vector<double>& sorted, double step) {
  const auto at = [&](std::size_t i) {  // in the middle of its place among equal ones
    const auto [first, last] = std::ranges::equal_range(sorted, sorted[i]);
    const auto place = static_cast<double>(sorted.begin() + static_cast<std::ptrdiff_t>(i) - first) + 0.5;
    return sorted[i] + step * (place / static_cast<double>(last - first) - 0.5);
  };
  const std::size_t top = sorted.size() - 1;
  return (at(top) - at(top - farther)) / std::max(at(top) - at(top - near_end), 1e-300);
}

/// Mean rank [1] of the values right beside gaps.
struct Gaps {
  std::size_t count = 0, missing = 0, first = 0;
  double rank = 0.0;
};

Gaps gaps_in(const std::vector<double>& x, const std::vector<double>& sorted) {
  Gaps gaps;
  double sum = 0.0, number = 0.0;
  const auto add = [&](double value) {
    if (std::isnan(value)) return;
    sum += static_cast<double>(std::ranges::lower_bound(sorted, value) - sorted.begin()) /
           static_cast<double>(sorted.size());
    ++number;
  };
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isnan(x[i])) continue;
    ++gaps.missing;
    if (i > 0 && !std::isnan(x[i - 1])) {
      if (gaps.count++ == 0) gaps.first = i;
      add(x[i - 1]);
    }
    if (i + 1 < x.size()) add(x[i + 1]);
  }
  gaps.rank = number > 0.0 ? sum / number : 0.5;
  return gaps;
}

Findings look_at(const Channel& channel) {
  std::vector<double> sorted;
  std::ranges::copy_if(channel.values, std::back_inserter(sorted), [](double v) { return std::isfinite(v); });
  const auto size = static_cast<double>(channel.values.size());
  if (size - static_cast<double>(sorted.size()) < least_missing * size || sorted.size() < 2 * farther) return {};
  std::ranges::sort(sorted);
  const double step = channel.kind == QuantityKind::count ? 1.0 : grain_of(channel.values).step;
  Gaps gaps = gaps_in(channel.values, sorted);
  if (gaps.count < least_gaps) return {};
  const double highest = end_of(sorted, step);
  std::vector<double> mirrored(sorted.rbegin(), sorted.rend());
  for (double& value : mirrored) value = -value;
  const double lowest = end_of(mirrored, step);
  const bool high = highest > edge && (lowest < edge || gaps.rank > greatest_rank);
  const bool low = lowest > edge && (highest < edge || gaps.rank < 1.0 - greatest_rank);
  if (high == low) return {};
  return {{Finding::Severity::error,
           high ? "largest_values_missing" : "smallest_values_missing",
           {{"limit", high ? sorted.back() : sorted.front(), channel.unit},
            {"part", static_cast<double>(gaps.missing) / size, "%"}},
           channel.name,
           {gaps.missing, channel.time(gaps.first)}}};
}

Findings run(const Recording& recording, const Plan* plan) {
  return findings_of_each(
      recording, [&](const Channel& channel) { return is_signal(channel, plan) ? look_at(channel) : Findings{}; });
}

}  // namespace

extern const Check lost_by_value{"lost_by_value",
                                 "missing samples of which the values decided: the largest or smallest ones", run};

}  // namespace tumble::checks::lost_by_value
