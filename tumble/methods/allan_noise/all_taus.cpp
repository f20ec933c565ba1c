#include "tumble/methods/allan_noise/all_taus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"

namespace tumble::allan_noise {
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

void shorten(std::size_t factors, EveryTau& every) {
  const std::size_t size = std::min(every.deviation.size(), factors);
  every.deviation.resize(size);
  every.count.resize(size);
}

/// The family's points of the Hadamard deviation; null where it was not asked for.
const FamilyCurve* hadamard(const ChannelNoise& channel) {
  const auto curve = std::find_if(channel.family.begin(), channel.family.end(), [](const FamilyCurve& one) {
    return one.measure == Stability::overlapping_hadamard;
  });
  return curve == channel.family.end() ? nullptr : &*curve;
}

/// Values of every factor with limits between those of `points`.
Curve curve_of(const ChannelNoise& channel, const EveryTau& every, const std::vector<DeviationPoint>& points) {
  Curve curve{.x = {"averaging time", Unit::parse("s")},
              .y = {"deviation", Unit::parse(rate_unit(channel.kind))},
              .band = fmt::format("{:g} % confidence", 100.0 * channel.confidence),
              .logarithmic = true};
  for (std::size_t k = 0; k < every.deviation.size(); ++k) {
    if (every.count[k] == 0) continue;
    const double deviation = every.deviation[k];
    const Limits limits = limits_at(points, k + 1);
    add_point(curve, static_cast<double>(k + 1) / channel.rate, deviation, limits.lower * deviation,
              limits.upper * deviation);
  }
  return curve;
}

}  // namespace

void add_all_taus(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  if (settings.word("taus") != "all") return;
  const auto longest =
      static_cast<std::size_t>(settings.number("longest_fraction") * static_cast<double>(signal.values.size()));
  shorten(longest, result.every.emplace(every_overlapping_allan(signal.values)));
  if (hadamard(result) != nullptr)
    shorten(longest, result.every_hadamard.emplace(every_overlapping_hadamard(signal.values)));
}

void describe_all_taus(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  for (const auto& channel : channels) {
    if (!channel.every || !channel.failure.empty() || channel.curve.empty()) continue;
    Curve curve = curve_of(channel, *channel.every, channel.curve);
    curve.name = channel.label + " every_averaging_time";
    curve.figure = "allan deviation " + channel.label;
    curve.y.name = "Allan deviation";
    estimate.curves.push_back(std::move(curve));
    if (!channel.every_hadamard) continue;
    Curve third = curve_of(channel, *channel.every_hadamard, hadamard(channel)->points);
    third.name = channel.label + " ohdev every_averaging_time";
    third.figure = "family of deviations " + channel.label;
    estimate.curves.push_back(std::move(third));
  }
}

}  // namespace tumble::allan_noise
