#include "tumble/reduce/lost_by_value.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

constexpr double end_width = 0.2;          ///< [sd of a sample] a natural end of noise holds one or two values
constexpr double fewest_at_end = 20.0;     ///< of a natural end: p < 1e-9
constexpr double most_at_other_end = 0.2;  ///< over those: a signal between two bounds ends abruptly at both
constexpr double least_missing = 0.01;     ///< of the samples

/// Number, extremes and the sd of a sample by differences of neighbours.
struct Spread {
  double low = INFINITY, high = -INFINITY, present = 0.0, sd = 0.0;
};

Spread spread_of(std::span<const double> values) {
  Spread of;
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    of.low = std::min(of.low, values[i]);
    of.high = std::max(of.high, values[i]);
    ++of.present;
    if (i == 0 || std::isnan(values[i - 1])) continue;
    squares += std::pow(values[i] - values[i - 1], 2);
    ++count;
  }
  if (count > 0.0) of.sd = std::sqrt(0.5 * squares / count);
  return of;
}

}  // namespace

Findings lost_by_value(std::span<const double> values, const std::string& label) {
  const auto all = static_cast<double>(values.size());
  const Spread of = spread_of(values);
  if (!(of.sd > 0.0) || all - of.present < least_missing * all) return {};
  double at_low = 0.0, at_high = 0.0;  // what stands at the extreme itself may be clipped, which is another fault
  for (const double value : values) {
    if (value > of.low && value - of.low < end_width * of.sd) ++at_low;
    if (value < of.high && of.high - value < end_width * of.sd) ++at_high;
  }
  const bool high = at_high > at_low;
  const double here = std::max(at_high, at_low), there = std::min(at_high, at_low);
  if (here < fewest_at_end || there > most_at_other_end * here) return {};
  return {{Finding::Severity::error,
           high ? "large_values_lost" : "small_values_lost",
           {{"part", (all - of.present) / all, "%"}, {"count", here}, {"other", there}},
           label}};
}

}  // namespace tumble
