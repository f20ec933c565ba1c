#include "tumble/methods/allan_noise/all_taus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

/// Limits over deviation at a factor, between those of the points of the curve beside it.
Limits limits_at(const std::vector<DeviationPoint>& curve, std::size_t factor) {
  const auto above = std::lower_bound(curve.begin(), curve.end(), factor,
                                      [](const DeviationPoint& point, std::size_t m) { return point.factor < m; });
  const auto of = [](const DeviationPoint& point) {
    return Limits{point.lower / point.deviation, point.upper / point.deviation};
  };
  if (above == curve.end()) return of(curve.back());
  if (above == curve.begin() || above->factor == factor) return of(*above);
  const auto below = above - 1;
  const double part = std::log(static_cast<double>(factor) / static_cast<double>(below->factor)) /
                      std::log(static_cast<double>(above->factor) / static_cast<double>(below->factor));
  const Limits one = of(*below), other = of(*above);
  return {one.lower + part * (other.lower - one.lower), one.upper + part * (other.upper - one.upper)};
}

}  // namespace

void add_all_taus(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  if (settings.word("taus") != "all") return;
  result.every = every_overlapping_allan(signal.values);
  const double longest = settings.number("longest_fraction") * static_cast<double>(signal.values.size());
  const std::size_t kept = std::min(result.every->deviation.size(), static_cast<std::size_t>(longest));
  result.every->deviation.resize(kept);
  result.every->count.resize(kept);
}

void describe_all_taus(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  for (const auto& channel : channels) {
    if (!channel.every || !channel.failure.empty() || channel.curve.empty()) continue;
    const Unit unit = Unit::parse(channel.kind == QuantityKind::angular_rate ? "deg/h" : "ug");
    Curve curve;
    curve.name = channel.label + " every_averaging_time";
    curve.figure = "allan deviation " + channel.label;
    curve.x = {"averaging time", Unit::parse("s"), {}};
    curve.y = {"Allan deviation", unit, {}};
    curve.band = fmt::format("{:g} % confidence", 100.0 * channel.confidence);
    curve.logarithmic = true;
    for (std::size_t k = 0; k < channel.every->deviation.size(); ++k) {
      if (channel.every->count[k] == 0) continue;
      const double deviation = channel.every->deviation[k];
      const Limits limits = limits_at(channel.curve, k + 1);
      curve.x.values.push_back(static_cast<double>(k + 1) / channel.rate);
      curve.y.values.push_back(deviation);
      curve.lower.push_back(limits.lower * deviation);
      curve.upper.push_back(limits.upper * deviation);
    }
    estimate.curves.push_back(std::move(curve));
  }
}

}  // namespace tumble
