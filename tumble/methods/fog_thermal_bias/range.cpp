#include "tumble/methods/fog_thermal_bias/range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace tumble::fog_thermal_bias {
namespace {

constexpr double beyond_slab = 0.02, slab_rounding = 1e-12;  ///< [1] of the range, and of its end, that count as inside

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  /// 1 over half the width; a width of nothing leaves the direction out.
  double weight() const { return high > low ? 2.0 / (high - low) : 0.0; }
};

using Weights = std::vector<std::pair<Input, double>>;

double value_of(const Weights& weights, const Felt& felt) {
  double sum = 0.0;
  for (const auto& [input, weight] : weights) sum += weight * Regressor(input)(felt);
  return sum;
}

/// Directions with whole components up to 2, one of each opposite pair, no multiples: 49.
std::vector<std::array<int, 3>> directions() {
  std::vector<std::array<int, 3>> out;
  for (int a = -2; a <= 2; ++a)
    for (int b = -2; b <= 2; ++b)
      for (int c = -2; c <= 2; ++c) {
        const bool positive = a > 0 || (a == 0 && (b > 0 || (b == 0 && c > 0)));
        if (positive && std::gcd(std::gcd(std::abs(a), std::abs(b)), std::abs(c)) == 1) out.push_back({a, b, c});
      }
  return out;
}

}  // namespace

std::vector<Covered> covered(const std::vector<RunData>& runs) {
  Span temperature, gradient, rate, start;
  each_average(runs, [&](const RunData& run, std::size_t k) {
    const Felt& felt = run.felt[k];
    temperature.add(felt.temperature);
    gradient.add(felt.temperature_gradient);
    rate.add(felt.temperature_rate);
    start.add(felt.start_temperature);
  });
  std::vector<Covered> all;
  const auto add = [&](const Weights& weights) {
    Span sum;
    each_average(runs, [&](const RunData& run, std::size_t k) { sum.add(value_of(weights, run.felt[k])); });
    all.push_back({weights, sum.low, sum.high});
  };
  for (const auto& d : directions()) {
    Weights weights;
    bool shown = true;
    for (const auto& [part, span, input] :
         {std::tuple{d[0], temperature, Input::temperature}, std::tuple{d[1], gradient, Input::temperature_gradient},
          std::tuple{d[2], rate, Input::temperature_rate}}) {
      if (part == 0) continue;
      weights.emplace_back(input, part * span.weight());
      shown = shown && span.weight() != 0.0;
    }
    if (shown) add(weights);
  }
  add({{Input::start_temperature, start.weight() > 0.0 ? start.weight() : 1.0}});
  return all;
}

InRange::InRange(std::vector<Covered> covered) : slabs_(std::move(covered)) {
  for (Covered& slab : slabs_) {
    // Two per cent of the width: unrest of the air moves the extremes of equal runs by about that much.
    const double slack = beyond_slab * (slab.greatest - slab.least) + slab_rounding * std::abs(slab.greatest);
    slab.least -= slack;
    slab.greatest += slack;
  }
}

bool InRange::operator()(const Felt& felt) const {
  return std::ranges::all_of(slabs_, [&](const Covered& slab) {
    const double sum = value_of(slab.weights, felt);
    return sum >= slab.least && sum <= slab.greatest;
  });
}

}  // namespace tumble::fog_thermal_bias
