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

std::vector<double> lag_column(const Circumstances& around, const std::vector<Observation>& observations,
                               std::size_t levels) {
  const Effect effect = lag_effect(around, observations, 1.0);
  std::vector<Complex> sum(levels);
  std::vector<double> weight(levels), column;
  for (std::size_t n = 0; n < observations.size(); ++n)
    for (const double w : observations[n].weight) {
      sum[observations[n].level] += w * effect.value[n];
      weight[observations[n].level] += w;
    }
  for (std::size_t l = 0; l < levels; ++l) {
    column.push_back(weight[l] > 0.0 ? sum[l].real() / weight[l] : 0.0);
    column.push_back(weight[l] > 0.0 ? sum[l].imag() / weight[l] : 0.0);
  }
  return column;
}

LagFit lag_of(const Quantities& levels, const Polynomial& polynomial) {
  const std::size_t last = polynomial.value.size() - 1;
  std::vector<double> row(levels.value.size());
  for (std::size_t n = 0; n < row.size(); ++n) row[n] = polynomial.of_levels(last, n);
  return {polynomial.value[last], std::sqrt(quadratic_form(row, levels.fit.covariance)),
          degrees_of_freedom(levels.fit, row)};
}

}  // namespace tumble::dtg_centrifuge
