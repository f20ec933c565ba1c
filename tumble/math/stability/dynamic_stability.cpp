#include "tumble/math/stability/dynamic_stability.hpp"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <string>

#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t shortest_window = 32;
constexpr double fewest_freedom = 2.0;

double variance(const DeviationPoint& point) { return point.deviation * point.deviation; }

bool counts(const DeviationPoint& point) { return point.count > 0 && point.edf >= fewest_freedom; }

/// A point for every factor, with the noise types found in the whole record.
std::vector<DeviationPoint> points_of(std::span<const double> rate, double sample_rate, const DynamicStability& record,
                                      double confidence) {
  const auto& factors = record.factors;
  std::vector<DeviationPoint> points(factors.size());
  if (std::ranges::all_of(rate, [](double value) { return std::isnan(value); })) return points;
  std::vector<int> alphas;
  for (const DeviationPoint& point : record.whole) alphas.push_back(point.alpha);
  for (const auto& point : overlapping_allan(rate, sample_rate, factors, confidence, alphas))
    points[static_cast<std::size_t>(std::ranges::find(factors, point.factor) - factors.begin())] = point;
  return points;
}

/// Two-sided probability of the ratio of window w to those two, four, ... windows away.
struct Comparison {
  double ratio = 1.0, chance = 1.0;
  bool made = false;
};

Comparison compare(const std::vector<StabilityWindow>& windows, std::size_t w, std::size_t factor) {
  const DeviationPoint& own = windows[w].points[factor];
  double sum = 0.0, freedom = 0.0;
  for (std::size_t v = w % 2; v < windows.size(); v += 2) {
    const DeviationPoint& other = windows[v].points[factor];
    if (v == w || !counts(other)) continue;
    sum += other.edf * variance(other);
    freedom += other.edf;
  }
  if (!counts(own) || !(sum > 0.0)) return {};
  const double ratio = variance(own) * freedom / sum;
  const boost::math::fisher_f_distribution<double> f(own.edf, freedom);
  return {ratio, 2.0 * std::min(cdf(f, ratio), cdf(complement(f, ratio))), true};
}

}  // namespace

DynamicStability dynamic_allan(std::span<const double> rate, double sample_rate, std::size_t windows,
                               double confidence) {
  if (windows < 3)
    throw Error(Error::Kind::bad_input, "at least 3 windows are needed, so that each has one that it does not overlap");
  const std::size_t hop = rate.size() / (windows + 1), size = 2 * hop;
  if (size < shortest_window)
    throw Error(Error::Kind::bad_data, say("windows of {} samples are too short: at least {} are needed in each",
                                           Name{std::to_string(size)}, Name{std::to_string(shortest_window)}));
  DynamicStability result;
  result.whole = overlapping_allan(rate, sample_rate, averaging_factors(size / 8, 0.0), confidence);
  for (const auto& point : result.whole) result.factors.push_back(point.factor);
  result.windows.resize(windows);
  parallel_for(windows, [&](std::size_t w) {
    const std::size_t first = w * hop;
    result.windows[w] = {first, size, points_of(rate.subspan(first, size), sample_rate, result, confidence)};
  });
  double least = 2.0;
  for (std::size_t w = 0; w < windows; ++w) {
    for (std::size_t i = 0; i < result.factors.size(); ++i) {
      const Comparison found = compare(result.windows, w, i);
      if (!found.made) continue;
      ++result.tests;
      if (found.chance >= least) continue;
      least = found.chance;
      result.worst_window = w;
      result.worst_factor = i;
      result.worst_ratio = found.ratio;
    }
  }
  if (result.tests > 0) result.chance = std::min(1.0, least * static_cast<double>(result.tests));
  return result;
}

}  // namespace tumble
