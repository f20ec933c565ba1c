#include "tumble/methods/dtg_centrifuge/lag.hpp"

#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::dtg_centrifuge {

std::vector<Measured> without_lag(std::vector<Measured> measured, Signal output, double seconds) {
  for (Measured& m : measured) {
    const auto turned = [&](Phasors& phasors) {
      for (std::size_t h = 0; h < 3; ++h)
        phasors.line[h] *= std::polar(1.0, static_cast<double>(h + 1) * m.theta_rate() * seconds);
      phasors.earth *= std::polar(1.0, m.beta_rate() * seconds);
    };
    Lines& lines = m.of[output];
    turned(lines.value);
    for (Phasors& part : lines.part) turned(part);
  }
  return measured;
}

LagColumn lag_column(const Circumstances& around, const std::vector<Observation>& observations, double known) {
  return {lag_effect(around, observations, usual_lag).value, known / usual_lag};
}

LagFit lag_of(const Quantities& levels, const Polynomial& polynomial) {
  const std::size_t last = polynomial.value.size() - 1;
  std::vector<double> row(levels.value.size());
  for (std::size_t n = 0; n < row.size(); ++n) row[n] = usual_lag * polynomial.of_levels(last, n);
  return {usual_lag * polynomial.value[last], std::sqrt(quadratic_form(row, levels.fit.covariance)), row};
}

Matrix levels_with_lag(const Quantities& levels, const Polynomial& polynomial) {
  const std::size_t n = levels.value.size();
  if (!polynomial.has_lag()) return identity(n);
  const std::size_t lag = n - 1, last = polynomial.value.size() - 1;
  const double variance = levels.fit.covariance(lag, lag);
  Matrix rows(lag, n);
  for (std::size_t i = 0; i < lag; ++i) {
    const double slope = variance > 0.0 ? levels.fit.covariance(i, lag) / variance : 0.0;
    rows(i, i) = 1.0;
    for (std::size_t k = 0; k < n; ++k) rows(i, k) += slope * (polynomial.of_levels(last, k) - (k == lag ? 1.0 : 0.0));
  }
  return rows;
}

}  // namespace tumble::dtg_centrifuge
