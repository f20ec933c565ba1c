#include "tumble/reduce/power_ups.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"

namespace tumble {
namespace {

/// Probability, in a sound test, of such a trend, or of such an outlier among all power-ups.
constexpr double rare_among_power_ups = 1e-3;
/// Of an outlier: the probability from which on both are possible, that it is one of the others and that it is none: one sound test in
/// twenty.
constexpr double doubtful_among_power_ups = 0.05;
/// Degrees of freedom that the scatter of the rest must have: with one, only 600 times the scatter is rare.
constexpr double least_freedom_of_power_ups = 2.0;

/// Probability of a column beside a design: by the scatter of the rest, or by the noise within the power-ups where that
/// is more.
LackOfFit one_more(const std::vector<double>& column, const Matrix& design, const std::vector<double>& values,
                   double noise) {
  const Matrix more = as_column(column), unit = identity(values.size());
  LackOfFit by_scatter = lack_of_fit(design, more, values, unit);
  if (by_scatter.error_freedom < least_freedom_of_power_ups) return {};
  if (!(noise > 0.0)) return by_scatter;
  const LackOfFit by_noise = lack_of_fit(design, more, values, noise * unit, std::numeric_limits<double>::infinity());
  by_scatter.probability = std::max(by_scatter.probability, by_noise.probability);
  return by_scatter;
}

/// What is compared of the power-ups.
struct Compared {
  std::vector<double> values;  ///< [u] less the first
  double noise = 0.0;          ///< [u^2] mean variance by noise within the power-ups
};

Compared compared(const std::vector<PowerUpValue>& powers) {
  Compared out;
  for (const PowerUpValue& one : powers) {
    out.values.push_back(one.value - powers.front().value);
    out.noise += one.variance / static_cast<double>(powers.size());
  }
  return out;
}

bool enough(std::size_t powers, const Matrix& design) {
  return powers >= design.columns + 1 + static_cast<std::size_t>(least_freedom_of_power_ups);
}

/// The power-up that is least like the others, and the probability of so much among all in a sound test.
struct LeastLike {
  std::size_t which = 0;
  double deviation = 0.0, among_all = 1.0;
};

LeastLike least_like(const Compared& of, const Matrix& design) {
  const std::size_t n = of.values.size();
  LackOfFit worst;
  std::size_t which = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> indicator(n, 0.0);
    indicator[k] = 1.0;
    const LackOfFit one = one_more(indicator, design, of.values, of.noise);
    if (one.probability < worst.probability) worst = one, which = k;
  }
  return {which, worst.coefficient, static_cast<double>(n) * worst.probability};
}

}  // namespace

Findings uneven_power_ups(const std::vector<PowerUpValue>& powers, const Matrix& design, const Unit& unit) {
  const std::size_t n = powers.size();
  if (!enough(n, design)) return {};
  const Compared of = compared(powers);
  std::vector<double> order(n);
  std::iota(order.begin(), order.end(), 0.0);
  const LackOfFit trend = one_more(order, design, of.values, of.noise);
  if (trend.probability < rare_among_power_ups)
    return {
        {Finding::Severity::warning,
         "power_ups_drift",
         {{"change", trend.coefficient * static_cast<double>(n - 1), unit}, {"runs", n}, {"p", trend.probability}}}};
  const LeastLike worst = least_like(of, design);
  if (worst.among_all >= rare_among_power_ups) return {};
  return {{Finding::Severity::warning,
           "power_up_differs",
           {{"deviation", worst.deviation, unit}, {"runs", n}, {"p", worst.among_all}},
           powers[worst.which].label}};
}

std::optional<std::size_t> doubtful_power_up(const std::vector<PowerUpValue>& powers, const Matrix& design) {
  if (!enough(powers.size(), design)) return {};
  const LeastLike worst = least_like(compared(powers), design);
  if (worst.among_all >= doubtful_among_power_ups) return {};
  return worst.which;
}

}  // namespace tumble
