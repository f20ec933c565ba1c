#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "tumble/math/median.hpp"
#include "tumble/reduce/vibration/faults.hpp"

namespace tumble::vibration {
namespace {

using Severity = Finding::Severity;

constexpr std::size_t windows_of_block = 32, fewest_present = 16, fewest_blocks = 16;
/// [1] of the median spread of the blocks: 32 normal numbers are below half of theirs with p = 1e-5.
constexpr double still_share = 0.5;
/// Change of the logarithm of the spread over the segment: [sd], p = 1e-8 with 16 blocks, and 5 %.
constexpr double ramp_sd = 8.0, least_ramp = 0.05;
/// A segment planned to vibrate does not: [1] of the quietest rest, and the plan wants so much more than that.
constexpr double as_at_rest = 1.5, planned_over_rest = 5.0;

/// Spread of each block of a vibration; NaN: too few windows are present.
std::vector<double> spreads_of(const Series& series) {
  std::vector<double> spreads;
  for (std::size_t from = 0; from + windows_of_block <= series.force.size(); from += windows_of_block) {
    const auto first = series.force.begin() + static_cast<std::ptrdiff_t>(from);
    const std::vector<double> block(first, first + windows_of_block);
    const auto present = std::ranges::count_if(block, [](double v) { return std::isfinite(v); });
    spreads.push_back(present < static_cast<std::ptrdiff_t>(fewest_present) ? std::nan("") : spread(block));
  }
  return spreads;
}

double median_present(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  return values.empty() ? std::nan("") : median(values);
}

/// Blocks at the beginning, or by the reverse order at the end, in which the unit hardly moves.
template <class Blocks>
std::size_t still_blocks(const Blocks& spreads, double moving) {
  std::size_t count = 0;
  for (const double one : spreads) {
    if (!(one < still_share * moving)) break;
    ++count;
  }
  return count;
}

/// The series without its first and last windows.
void leave_out(std::size_t first, std::size_t last, Series& series) {
  const std::size_t end = series.force.size() - last;
  const auto cut = [&](std::vector<double>& values) {
    if (values.empty()) return;
    values = std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(first),
                                 values.begin() + static_cast<std::ptrdiff_t>(end));
  };
  cut(series.time);
  cut(series.force);
  cut(series.reference);
  series.begin += static_cast<double>(first) * series.interval;
  series.end -= static_cast<double>(last) * series.interval;
}

/// Cuts a series to the time in which it vibrates, with a finding.
void cut_to_vibration(Series& series, Findings& findings) {
  const std::vector<double> spreads = spreads_of(series);
  if (spreads.size() < fewest_blocks) return;
  const double moving = median_present(spreads);
  std::size_t begin = still_blocks(spreads, moving);
  std::size_t end = still_blocks(std::vector<double>(spreads.rbegin(), spreads.rend()), moving);
  if (begin + end == 0 || 2 * (begin + end) >= spreads.size()) return;
  // in the next block it begins or ends
  if (begin > 0) begin = (begin + 1) * windows_of_block;
  if (end > 0) end = (end + 1) * windows_of_block + series.force.size() % windows_of_block;
  leave_out(begin, end, series);
  add_once({Severity::warning,
            "vibration_not_throughout",
            {{"begin", static_cast<double>(begin) * series.interval, "s"},
             {"end", static_cast<double>(end) * series.interval, "s"}},
            series.label},
           findings);
}

/// A finding where the vibration becomes stronger or weaker along the segment.
void check_ramp(const Data& data, const Series& series, Findings& findings) {
  const std::vector<double> spreads = spreads_of(series);
  double n = 0.0, place = 0.0, level = 0.0, squares = 0.0, products = 0.0, left = 0.0;
  const auto each = [&](const auto& use) {
    for (std::size_t b = 0; b < spreads.size(); ++b)
      if (spreads[b] > 0.0)
        use((static_cast<double>(b) + 0.5) / static_cast<double>(spreads.size()), std::log(spreads[b]));
  };
  each([&](double t, double v) { ++n, place += t, level += v; });
  if (n < static_cast<double>(fewest_blocks)) return;
  place /= n, level /= n;
  each([&](double t, double v) { squares += (t - place) * (t - place), products += (t - place) * (v - level); });
  const double change = products / squares;
  each([&](double t, double v) { left += std::pow(v - level - change * (t - place), 2); });
  const double sd = std::sqrt(left / (n - 2.0) / squares);
  if (std::abs(change) < std::max(ramp_sd * sd, least_ramp)) return;
  findings.push_back(
      {Severity::warning, "vibration_not_steady", {{"change", std::expm1(change), "%"}}, place_of(data, series)});
}

}  // namespace

void cut_to_vibrations(Data& data) {
  for (Series& series : data.series)
    if (series.shake.kind == Motion::Kind::random) cut_to_vibration(series, data.findings);
}

void check_ramps(Data& data) {
  for (const Series& series : data.series)
    if (series.shake.kind == Motion::Kind::random) check_ramp(data, series, data.findings);
}

void drop_still(Data& data) {
  std::vector<double> quietest(data.units.size(), INFINITY);
  for (const Series& s : data.series)
    if (s.at_rest()) quietest[s.unit] = std::min(quietest[s.unit], spread(s.force));
  std::erase_if(data.series, [&](const Series& s) {
    const double rest = quietest[s.unit], shown = spread(s.force);
    if (s.shake.kind != Motion::Kind::random || !std::isfinite(rest) || shown > as_at_rest * rest) return false;
    if (planned_sd(s) < planned_over_rest * shown) return false;
    data.findings.push_back({Severity::error,
                             "vibration_absent",
                             {{"shown", shown, "g"}, {"planned", planned_sd(s), "g"}},
                             place_of(data, s)});
    return true;
  });
}

}  // namespace tumble::vibration
