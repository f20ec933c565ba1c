#include "tumble/math/population/vector_population.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr std::size_t folds = 5;
constexpr std::array shrinkages{2.0, 5.0, 10.0, 20.0, 50.0, std::numeric_limits<double>::infinity()};

std::vector<std::size_t> seen(const UnitVector& unit) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < unit.values.size(); ++k)
    if (!std::isnan(unit.values[k])) out.push_back(k);
  return out;
}

Matrix part(const Matrix& a, const std::vector<std::size_t>& which) {
  return chosen_columns(chosen_rows(a, which), which);
}

std::vector<double> part(const std::vector<double>& a, const std::vector<std::size_t>& which) {
  std::vector<double> out;
  for (const auto k : which) out.push_back(a[k]);
  return out;
}

void require_vectors(std::span<const UnitVector> units) {
  std::vector<std::string> problems;
  if (units.size() < folds)
    problems.push_back(fmt::format("a population needs at least five units; here {} given", units.size()));
  const auto p = units.empty() ? 0 : units.front().values.size();
  std::vector<std::size_t> shown(p);
  for (std::size_t u = 0; u < units.size(); ++u) {
    const auto& unit = units[u];
    if (unit.values.size() != p || unit.covariance.rows != p || unit.covariance.columns != p) {
      problems.push_back(fmt::format("unit {} has {} parameters, the first {}", u + 1, unit.values.size(), p));
      continue;
    }
    const auto which = seen(unit);
    for (const auto k : which) ++shown[k];
    if (!which.empty() && !cholesky(part(unit.covariance, which)).positive)
      problems.push_back(fmt::format("the covariance of unit {} is not positive definite", u + 1));
  }
  for (std::size_t k = 0; k < p; ++k)
    if (shown[k] < 3)
      problems.push_back(fmt::format("parameter {} is shown by {} units; three are needed", k + 1, shown[k]));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// (T + C)^-1 of the parameters that the unit shows, zero elsewhere.
Matrix precision(const UnitVector& unit, const Matrix& spread) {
  const auto which = seen(unit);
  const Matrix some = inverse_symmetric(part(spread, which) + part(unit.covariance, which));
  Matrix out(spread.rows, spread.columns);
  for (std::size_t j = 0; j < which.size(); ++j)
    for (std::size_t i = 0; i < which.size(); ++i) out(which[i], which[j]) = some(i, j);
  return out;
}

/// y - mean; zero where the unit shows nothing.
std::vector<double> departure(const UnitVector& unit, const std::vector<double>& mean) {
  std::vector<double> out;
  for (std::size_t k = 0; k < mean.size(); ++k)
    out.push_back(std::isnan(unit.values[k]) ? 0.0 : unit.values[k] - mean[k]);
  return out;
}

struct MeanOfUnits {
  std::vector<Matrix> precisions;
  std::vector<double> mean;
  Matrix covariance;
};

MeanOfUnits mean_of(std::span<const UnitVector> units, const Matrix& spread) {
  const auto p = spread.rows;
  MeanOfUnits out;
  Matrix information(p, p);
  std::vector<double> right(p, 0.0);
  for (const auto& unit : units) {
    const auto& m = out.precisions.emplace_back(precision(unit, spread));
    information = information + m;
    right = scaled_sum(right, 1.0, m * departure(unit, std::vector<double>(p, 0.0)));
  }
  out.covariance = inverse_symmetric(information);
  out.mean = out.covariance * right;
  return out;
}

/// One step of (8.10) and (8.11).
Matrix next_spread(std::span<const UnitVector> units, const Matrix& spread, double shrinkage) {
  const auto p = spread.rows;
  const auto n = static_cast<double>(units.size());
  const auto at = mean_of(units, spread);
  Matrix sum(p, p);
  for (std::size_t u = 0; u < units.size(); ++u) {
    const Matrix w = spread * at.precisions[u];
    const auto shift = as_column(w * departure(units[u], at.mean));
    sum = sum + shift * transposed(shift) + w * at.covariance * transposed(w) + spread - w * spread;
  }
  Matrix out(p, p);
  const double keep = std::isinf(shrinkage) ? 0.0 : n / (n + shrinkage);
  for (std::size_t j = 0; j < p; ++j)
    for (std::size_t i = 0; i < p; ++i) out(i, j) = (i == j ? 1.0 : keep) * 0.5 * (sum(i, j) + sum(j, i)) / n;
  return out;
}

/// Variances of the results of each parameter: where the search for T begins.
Matrix first_spread(std::span<const UnitVector> units) {
  std::vector<double> variances;
  for (std::size_t k = 0; k < units.front().values.size(); ++k) {
    double count = 0.0, sum = 0.0, squares = 0.0;
    for (const auto& unit : units)
      if (!std::isnan(unit.values[k])) count += 1.0, sum += unit.values[k];
    for (const auto& unit : units)
      if (!std::isnan(unit.values[k])) squares += square(unit.values[k] - sum / count);
    variances.push_back(squares / (count - 1.0));
  }
  return diagonal(variances);
}

Matrix most_likely_covariance(std::span<const UnitVector> units, double shrinkage, int most_steps) {
  Matrix spread = first_spread(units);
  for (int step = 0; step < most_steps; ++step) {
    const Matrix next = next_spread(units, spread, shrinkage);
    double change = 0.0;
    for (std::size_t k = 0; k < spread.rows; ++k)
      change = std::max(change, std::abs(next(k, k) - spread(k, k)) / std::max(spread(k, k), 1e-300));
    spread = next;
    if (change < 1e-5) break;
  }
  return spread;
}

/// D of a result, and ln N of it without constants, where `covariance` is that of its departure.
std::pair<double, double> distance_of(const UnitVector& unit, const std::vector<double>& mean,
                                      const Matrix& covariance) {
  const auto which = seen(unit);
  const auto factor = cholesky(part(covariance, which));
  if (!factor.positive) throw Error(Error::Kind::bad_data, "the covariance of a unit is not positive definite");
  const auto away = part(departure(unit, mean), which);
  const double d = dot(away, solve(factor, away));
  return {d, -0.5 * (factor.log_determinant + d + static_cast<double>(which.size()) * std::log(two_pi))};
}

struct Predicted {
  double log_likelihood = 0.0;
  double inflation = 0.0;  ///< mean of D/p
};

/// How well the units of each fold are predicted by the others.
Predicted predicted(std::span<const UnitVector> units, double shrinkage) {
  Predicted out;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<UnitVector> others;
    for (std::size_t u = 0; u < units.size(); ++u)
      if (u % folds != fold) others.push_back(units[u]);
    const Matrix spread = most_likely_covariance(others, shrinkage, 60);
    const auto at = mean_of(others, spread);
    for (std::size_t u = fold; u < units.size(); u += folds) {
      if (seen(units[u]).empty()) continue;
      const auto [d, log] = distance_of(units[u], at.mean, spread + at.covariance + units[u].covariance);
      out.log_likelihood += log;
      out.inflation += d / static_cast<double>(seen(units[u]).size()) / static_cast<double>(units.size());
    }
  }
  return out;
}

}  // namespace

VectorPopulation vector_population(std::span<const UnitVector> units) {
  require_vectors(units);
  VectorPopulation out;
  double best = -std::numeric_limits<double>::infinity();
  for (const double shrinkage : shrinkages) {
    const auto score = predicted(units, shrinkage);
    if (!(score.log_likelihood > best)) continue;
    best = score.log_likelihood;
    out.shrinkage = shrinkage, out.inflation = std::max(1.0, score.inflation);
  }
  out.spread = most_likely_covariance(units, out.shrinkage, 500);
  const auto at = mean_of(units, out.spread);
  out.mean = at.mean, out.mean_covariance = at.covariance;
  out.units = units.size();
  return out;
}

VectorInPopulation vector_in_population(const VectorPopulation& population, const ShownOfUnit& unit,
                                        const Matrix& shared) {
  const auto p = population.mean.size(), m = unit.values.size();
  const Matrix& a = unit.combinations;
  if (a.columns != p || a.rows != m || unit.covariance.rows != m)
    throw Error(Error::Kind::bad_data, fmt::format("the unit has {} parameters, its population {}", a.columns, p));
  const Matrix prior = population.spread + population.mean_covariance;
  const Matrix k = shared.rows == m ? shared : Matrix(m, p);
  const Matrix cross = a * prior - k;  // [m x p]: of the departure with the parameters' departure from the mean
  const Matrix both = k * transposed(a);
  const auto factor = cholesky(a * prior * transposed(a) + unit.covariance - both - transposed(both));
  if (!factor.positive) throw Error(Error::Kind::bad_data, "the covariance of a unit is not positive definite");
  std::vector<double> away = scaled_sum(unit.values, -1.0, a * population.mean);
  VectorInPopulation out;
  out.degrees_of_freedom = static_cast<double>(population.units) - 1.0;
  out.distance = dot(away, solve(factor, away));
  out.values = scaled_sum(population.mean, 1.0, transposed_product(cross, solve(factor, away)));
  out.covariance = prior - transposed_product(cross, solve(factor, cross));
  const double dimensions = static_cast<double>(m), c = population.inflation;
  out.belongs = m == 0    ? 1.0
                : c > 1.0 ? cdf(complement(boost::math::fisher_f(dimensions, std::max(4.1, 2.0 * c / (c - 1.0))),
                                           out.distance / dimensions))
                          : cdf(complement(boost::math::chi_squared(dimensions), out.distance));
  return out;
}

VectorInPopulation vector_in_population(const VectorPopulation& population, const UnitVector& unit,
                                        const Matrix& shared) {
  const auto which = seen(unit);
  return vector_in_population(population,
                              ShownOfUnit{chosen_rows(identity(unit.values.size()), which), part(unit.values, which),
                                          part(unit.covariance, which)},
                              shared.rows == 0 ? shared : chosen_rows(shared, which));
}

}  // namespace tumble
