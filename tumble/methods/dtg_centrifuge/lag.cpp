#include "tumble/methods/dtg_centrifuge/lag.hpp"

#include <cmath>
#include <utility>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr std::size_t lag_of_harmonic = 2;  // behind its two parts
constexpr double anything = 50.0;           ///< [usual_lag] of a lag of which nothing is known: a second

}  // namespace

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

Complex Filter::response(double rate) const {
  if (stages == 0) return 1.0;
  const double each = lag / static_cast<double>(stages), part = step / (step + each);
  const Complex one =
      step > 0.0 ? part / (1.0 - (1.0 - part) * std::polar(1.0, -rate * step)) : 1.0 / Complex(1.0, rate * each);
  return std::pow(one, static_cast<double>(stages));
}

std::vector<Measured> without_filter(std::vector<Measured> measured, Signal output, const Filter& filter) {
  for (Measured& m : measured) {
    const auto corrected = [&](Phasors& phasors) {
      for (std::size_t h = 0; h < 3; ++h)
        phasors.line[h] /= filter.response(static_cast<double>(h + 1) * m.theta_rate());
      phasors.earth /= filter.response(m.beta_rate());
    };
    Lines& lines = m.of[output];
    corrected(lines.value);
    for (Phasors& part : lines.part) corrected(part);
  }
  return measured;
}

LagColumn lag_column(const Circumstances& around, const std::vector<Observation>& observations, double corrected,
                     const std::vector<Quantities>& harmonics) {
  double weight = 1.0, sum = -corrected / usual_lag;
  for (const Quantities& harmonic : harmonics) {
    if (harmonic.value.size() <= lag_of_harmonic) continue;
    const double variance = harmonic.fit.covariance(lag_of_harmonic, lag_of_harmonic);
    weight += 1.0 / variance;
    sum += harmonic.value[lag_of_harmonic] / variance;
  }
  return {lag_effect(around, observations, usual_lag).value, sum / weight, 1.0 / std::sqrt(weight)};
}

Quantities harmonic_with_lag(const Circumstances& around, const std::vector<Observation>& observations,
                             const std::vector<Effect>& effects, int harmonic) {
  Quantities plain = fit_harmonic(observations, effects, harmonic, {});
  const auto solved = solve_symmetric(plain.fit.covariance, plain.value);
  if (!(dot(solved, plain.value) > significant_harmonic * significant_harmonic)) return plain;
  // that of the mean harmonic: the noise of a single one would feign a lag of zero
  std::vector<Observation> mean = observations;
  for (Observation& one : mean) (harmonic == 2 ? one.second : one.third) = Complex(plain.value[0], plain.value[1]);
  Effect lag = lag_effect(around, mean, usual_lag);
  return fit_harmonic(observations, effects, harmonic,
                      {harmonic == 2 ? std::move(lag.second) : std::move(lag.third), 0.0, anything});
}

HarmonicPart harmonic_part(const Quantities& harmonic, std::size_t part, const Quantities& levels,
                           const Polynomial& polynomial) {
  HarmonicPart out{harmonic.value[part], std::vector<double>(harmonic.value.size()),
                   std::vector<double>(levels.value.size())};
  out.by_harmonic[part] = 1.0;
  if (harmonic.value.size() <= lag_of_harmonic || !polynomial.has_lag()) return out;
  const Matrix& covariance = harmonic.fit.covariance;
  const double slope = covariance(part, lag_of_harmonic) / covariance(lag_of_harmonic, lag_of_harmonic);
  const std::size_t last = polynomial.value.size() - 1;
  out.value += slope * (polynomial.value[last] - harmonic.value[lag_of_harmonic]);
  out.by_harmonic[lag_of_harmonic] = -slope;
  for (std::size_t n = 0; n < out.by_levels.size(); ++n) out.by_levels[n] = slope * polynomial.of_levels(last, n);
  return out;
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
