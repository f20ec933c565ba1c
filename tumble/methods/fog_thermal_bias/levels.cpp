#include "tumble/methods/fog_thermal_bias/levels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tumble/math/bisection.hpp"
#include "tumble/math/linear_algebra.hpp"

namespace tumble::fog_thermal_bias {
namespace {

constexpr double greatest_level_condition = 1e6;  ///< of the polynomial in the levels: beyond it they are too few

/// Independent contrasts between the levels that the polynomial does not explain, with their known variances.
struct Contrasts {
  std::vector<double> values, variances;
};

Contrasts contrasts_of(const Matrix& polynomial, const std::vector<double>& levels, const Matrix& known) {
  const std::size_t n = levels.size(), p = polynomial.columns;
  const Matrix q = q_product(householder_qr(polynomial), identity(n));
  const Matrix outside = block(q, 0, n, p, n - p);
  const auto eigen = eigen_symmetric(sandwich(transposed(outside), known));
  Contrasts out{transposed_product(eigen.vectors, transposed_product(outside, levels)), eigen.values};
  for (double& v : out.variances) v = std::max(v, 0.0);
  return out;
}

/// Variance that the contrasts have beyond what is known: the zero of the score of their likelihood, or none.
double restricted_variance(const Contrasts& contrasts) {
  double total = 0.0;
  for (const double u : contrasts.values) total += u * u;
  const auto score = [&](double s) {
    double sum = 0.0;
    for (std::size_t k = 0; k < contrasts.values.size(); ++k) {
      const double v = contrasts.variances[k] + s;
      sum += (contrasts.values[k] * contrasts.values[k] - v) / (v * v);
    }
    return sum;
  };
  constexpr double least_share = 1e-12, most_share = 10.0;  // of the sum of squares: of no effect; above any zero
  constexpr int halvings = 80;                              // of the logarithm of the variance: to rounding
  const double least = least_share * total, most = most_share * total;
  if (!(least > 0.0) || score(least) <= 0.0) return 0.0;
  return std::exp(bisected(std::log(least), std::log(most), halvings, [&](double logarithm) {
                    return score(std::exp(logarithm)) > 0.0;
                  }).high);
}

/// Mean of the known variances of the contrasts, weighted as the turn-on variance is, and the sum of the weights.
std::pair<double, double> weighted_variance(const Contrasts& contrasts, double turn_on_variance) {
  double information = 0.0, weighted = 0.0;
  for (const double v : contrasts.variances) {
    const double weight = std::pow(v + turn_on_variance, -2);
    information += weight;
    weighted += weight * v;
  }
  return {weighted / information, information};
}

}  // namespace

LevelFit fit_levels(const std::vector<RunLevel>& levels, const std::vector<double>& parameters,
                    const Matrix& covariance, const std::vector<double>& start_difference, std::size_t powers,
                    double inflation, double known_turn_on) {
  const std::size_t n = levels.size(), q = parameters.size();
  LevelFit out;
  Matrix regressors(n, q), polynomial(n, powers);
  std::vector<double> values(n), own(n);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < q; ++c) regressors(r, c) = levels[r].regressors[c];
    for (std::size_t j = 0; j < powers; ++j) polynomial(r, j) = std::pow(start_difference[r], static_cast<double>(j));
    own[r] = inflation * levels[r].variance;
    values[r] = levels[r].output - dot(levels[r].regressors, parameters);
  }
  const auto unit = inverses(column_norms(polynomial));
  const Matrix scaled_polynomial = scaled_columns(polynomial, unit);
  if (condition(scaled_polynomial) > greatest_level_condition) return out;
  const Matrix known = diagonal(own) + sandwich(regressors, covariance);
  const Contrasts contrasts = contrasts_of(polynomial, values, known);
  out.turn_on_variance = known_turn_on >= 0.0 ? known_turn_on : restricted_variance(contrasts);
  const auto [noise, information] = weighted_variance(contrasts, out.turn_on_variance);
  out.noise_variance = noise;
  const double total = out.turn_on_variance + out.noise_variance, spread = 2.0 / information;
  out.total_freedom = std::min(static_cast<double>(n - powers), 2.0 * total * total / spread);
  const Matrix weights = inverse_symmetric(known + out.turn_on_variance * identity(n));
  const Matrix towards = transposed_product(scaled_polynomial, weights);
  out.of_levels = scaled_rows(unit, solve_symmetric(towards * scaled_polynomial, towards));
  out.bias = out.of_levels * values;
  out.of_coefficients = -1.0 * (out.of_levels * regressors);
  out.noise = sandwich(out.of_levels, known);
  const Matrix squares = sandwich(out.of_levels, identity(n));
  out.scatter = out.turn_on_variance * squares;
  for (std::size_t j = 0; j < powers; ++j) {
    const double variance = out.noise(j, j) + out.scatter(j, j), by_scatter = squares(j, j);
    out.degrees_of_freedom.push_back(std::max(1.0, 2.0 * variance * variance / (spread * by_scatter * by_scatter)));
  }
  return out;
}

}  // namespace tumble::fog_thermal_bias
