#include "tumble/methods/fog_thermal_bias/range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/reduce/compensation/outputs.hpp"

namespace tumble::fog_thermal_bias {
namespace {

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  /// 1 over half the width; a width of nothing leaves the direction out.
  double weight() const { return high > low ? 2.0 / (high - low) : 0.0; }
};

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

Table calibrated_range(const std::vector<RunData>& runs) {
  Span temperature, gradient, rate, start;
  each_average(runs, [&](const RunData& run, std::size_t k) {
    const Felt& felt = run.felt[k];
    temperature.add(felt.temperature);
    gradient.add(felt.temperature_gradient);
    rate.add(felt.temperature_rate);
    start.add(felt.start_temperature);
  });
  Table table{"calibrated_range",
              "weighted sums of temperature, gradient, rate and start temperature that the fitted runs covered",
              {{"temperature_weight", Unit::parse("1/K")},
               {"gradient_weight", Unit::parse("1/K")},
               {"rate_weight", Unit::parse("s/K")},
               {"start_weight", Unit::parse("1/K")},
               {"lower", Unit{}},
               {"upper", Unit{}}},
              {},
              true};
  const auto add_row = [&](double t, double g, double r, double s) {
    Span sum;
    each_average(runs, [&](const RunData& run, std::size_t k) {
      const Felt& felt = run.felt[k];
      sum.add(t * felt.temperature + g * felt.temperature_gradient + r * felt.temperature_rate +
              s * felt.start_temperature);
    });
    table.rows.push_back({t, g, r, s, sum.low, sum.high});
  };
  for (const auto& d : directions()) {
    const double t = d[0] * temperature.weight(), g = d[1] * gradient.weight(), r = d[2] * rate.weight();
    if ((d[0] != 0 && t == 0.0) || (d[1] != 0 && g == 0.0) || (d[2] != 0 && r == 0.0)) continue;
    add_row(t, g, r, 0.0);
  }
  add_row(0.0, 0.0, 0.0, start.weight() > 0.0 ? start.weight() : 1.0);
  return table;
}

InRange::InRange(const Table& table) {
  for (const auto& row : table.rows) {
    const auto cell = [&](std::size_t c) { return compensation::number_in(table, row.at(c)); };
    // Two per cent of the width: unrest of the air moves the extremes of equal runs by about that much.
    const double slack = 0.02 * (cell(5) - cell(4)) + 1e-12 * std::abs(cell(5));
    slabs_.push_back({cell(0), cell(1), cell(2), cell(3), cell(4) - slack, cell(5) + slack});
  }
}

bool InRange::operator()(const Felt& felt) const {
  return std::ranges::all_of(slabs_, [&](const Slab& slab) {
    const double sum = slab.temperature * felt.temperature + slab.gradient * felt.temperature_gradient +
                       slab.rate * felt.temperature_rate + slab.start * felt.start_temperature;
    return sum >= slab.lower && sum <= slab.upper;
  });
}

}  // namespace tumble::fog_thermal_bias
