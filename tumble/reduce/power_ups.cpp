#include "tumble/reduce/power_ups.hpp"

#include <algorithm>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"

namespace tumble {
namespace {

/// Probability, in a sound test, of such a trend, or of such an outlier among all power-ups.
constexpr double rare_among_power_ups = 1e-3;
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

}  // namespace

Findings uneven_power_ups(const std::vector<PowerUpValue>& powers, const Matrix& design, const Unit& unit) {
  const std::size_t n = powers.size();
  if (n < design.columns + 1 + static_cast<std::size_t>(least_freedom_of_power_ups)) return {};
  std::vector<double> values, order;
  double noise = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    values.push_back(powers[k].value - powers.front().value);
    order.push_back(static_cast<double>(k));
    noise += powers[k].variance / static_cast<double>(n);
  }
  const LackOfFit trend = one_more(order, design, values, noise);
  if (trend.probability < rare_among_power_ups)
    return {
        {Finding::Severity::warning,
         "power_ups_drift",
         {{"change", trend.coefficient * static_cast<double>(n - 1), unit}, {"runs", n}, {"p", trend.probability}}}};
  LackOfFit worst;
  std::size_t which = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> indicator(n, 0.0);
    indicator[k] = 1.0;
    const LackOfFit one = one_more(indicator, design, values, noise);
    if (one.probability < worst.probability) worst = one, which = k;
  }
  const double among_all = static_cast<double>(n) * worst.probability;
  if (among_all >= rare_among_power_ups) return {};
  return {{Finding::Severity::warning,
           "power_up_differs",
           {{"deviation", worst.coefficient, unit}, {"runs", n}, {"p", among_all}},
           powers[which].label}};
}

}  // namespace tumble
