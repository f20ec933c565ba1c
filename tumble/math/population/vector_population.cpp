#include "tumble/math/population/vector_population.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/population/expected_spread.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/math/square.hpp"
#include "tumble/math/symmetric_factor.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double added_variance = 1e-10;            ///< [1] of each: values that errors move together are allowed
constexpr double least_of_own = 1e-6;               ///< [1] of the units' own variance, where a spread begins
constexpr double last_change_of_spread = 1e-5;      ///< [1]
constexpr double least_freedom_of_belonging = 4.1;  ///< F has a variance above 4

constexpr std::size_t folds = 5;
constexpr std::size_t least_units = 5;  ///< that show a parameter by itself
constexpr std::size_t enough = 100;     ///< units above which correlations need no shrinking
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

bool positive_semidefinite(const Matrix& a) {
  for (std::size_t i = 0; i < a.rows; ++i)
    if (!(a(i, i) >= 0.0) || !std::isfinite(a(i, i))) return false;
  return symmetric_factor(a).excess < rounding_share;
}

/// The parameter that value i of a unit is by itself; p: it is a sum.
std::size_t alone(const ShownOfUnit& unit, std::size_t i) {
  std::size_t only = unit.combinations.columns;
  for (std::size_t k = 0; k < unit.combinations.columns; ++k) {
    if (unit.combinations(i, k) == 0.0) continue;
    if (only != unit.combinations.columns || unit.combinations(i, k) != 1.0) return unit.combinations.columns;
    only = k;
  }
  return only;
}

void require_vectors(std::span<const ShownOfUnit> units) {
  Problems problems;
  if (units.size() < folds)
    problems.push_back(say("a population needs at least five units; here {} given", units.size()));
  const auto p = units.empty() ? 0 : units.front().combinations.columns;
  std::vector<std::size_t> shown(p + 1);
  for (std::size_t u = 0; u < units.size(); ++u) {
    const auto& unit = units[u];
    const auto m = unit.values.size();
    if (unit.combinations.columns != p || unit.combinations.rows != m || unit.covariance.rows != m ||
        unit.shared.columns != units.front().shared.columns) {
      problems.push_back(say("unit {} has {} parameters, the first {}", u + 1, unit.combinations.columns, p));
      continue;
    }
    for (std::size_t i = 0; i < m; ++i) ++shown[alone(unit, i)];
    if (!positive_semidefinite(unit.covariance))
      problems.push_back(say("the covariance of unit {} is not positive semidefinite", u + 1));
  }
  for (std::size_t k = 0; k < p; ++k)
    if (shown[k] < least_units)
      problems.push_back(say("parameter {} is shown by {} units; {} are needed", k + 1, shown[k], least_units));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// What one unit contributes at a spread T.
struct WeighedUnit {
  Matrix precision;          ///< A' S^-1 A
  std::vector<double> pull;  ///< A' S^-1 (y - A mean - B errors)
  Matrix passed;             ///< A' S^-1 [A | B]
};

/// Mean and shared errors of all units at a spread T: unknowns are [mean; shared errors].
struct MeanOfUnits {
  std::vector<WeighedUnit> weighed;
  std::vector<double> unknowns;
  Matrix covariance;

  std::vector<double> mean(std::size_t p) const {
    return {unknowns.begin(), unknowns.begin() + static_cast<std::ptrdiff_t>(p)};
  }
};

Matrix design_of(const ShownOfUnit& unit) {
  return unit.shared.columns == 0 ? unit.combinations : beside(unit.combinations, unit.shared);
}

/// S = A T A' + E. Throws where it is not positive definite.
Cholesky scatter_of(const ShownOfUnit& unit, const Matrix& spread) {
  Matrix s = sandwich(unit.combinations, spread) + unit.covariance;
  for (std::size_t i = 0; i < s.rows; ++i)
    s(i, i) *= 1.0 + added_variance;  // values that errors move together are allowed
  auto factor = cholesky(s);
  if (!factor.positive) throw Error(Error::Kind::bad_data, "the covariance of a unit is not positive definite");
  return factor;
}

MeanOfUnits mean_of(std::span<const ShownOfUnit> units, const Matrix& spread) {
  const std::size_t p = spread.rows, unknowns = p + units.front().shared.columns;
  MeanOfUnits out;
  Matrix information(unknowns, unknowns);
  std::vector<double> right(unknowns, 0.0);
  for (std::size_t k = p; k < unknowns; ++k) information(k, k) = 1.0;
  std::vector<std::vector<double>> solved;
  for (const auto& unit : units) {
    auto& weighed = out.weighed.emplace_back();
    if (unit.values.empty()) {
      weighed = {Matrix(p, p), std::vector<double>(p, 0.0), Matrix(p, unknowns)};
      continue;
    }
    const Matrix design = design_of(unit);
    const auto factor = scatter_of(unit, spread);
    const Matrix part = solve(factor, design);
    information += transposed_product(design, part);
    right = scaled_sum(right, 1.0, transposed_product(part, unit.values));
    weighed.passed = transposed_product(unit.combinations, part);
    weighed.precision = block(weighed.passed, 0, p, 0, p);
    weighed.pull = transposed_product(block(part, 0, part.rows, 0, p), unit.values);
  }
  out.covariance = inverse_symmetric(information);
  out.unknowns = out.covariance * right;
  for (auto& weighed : out.weighed) weighed.pull = scaled_sum(weighed.pull, -1.0, weighed.passed * out.unknowns);
  return out;
}

/// One step of (8.10) and (8.11).
Matrix next_spread(std::span<const ShownOfUnit> units, const Matrix& spread, double shrinkage) {
  const auto p = spread.rows;
  const auto n = static_cast<double>(units.size());
  const auto at = mean_of(units, spread);
  Matrix sum(p, p);
  for (const auto& weighed : at.weighed) {
    const auto shift = spread * weighed.pull;
    add_square(sum, 1.0, shift);
    sum += sandwich(spread * weighed.passed, at.covariance) + spread - sandwich(spread, weighed.precision);
  }
  Matrix out(p, p);
  const double keep = std::isinf(shrinkage) ? 0.0 : n / (n + shrinkage);
  for (std::size_t j = 0; j < p; ++j)
    for (std::size_t i = 0; i < p; ++i) out(i, j) = (i == j ? 1.0 : keep) * 0.5 * (sum(i, j) + sum(j, i)) / n;
  return out;
}

/// Values of each parameter that units show by itself.
std::vector<std::vector<KeyedUnitValue>> values_alone(std::span<const ShownOfUnit> units) {
  const std::size_t p = units.front().combinations.columns;
  std::vector<std::vector<KeyedUnitValue>> out(p);
  for (const auto& unit : units)
    for (std::size_t i = 0; i < unit.values.size(); ++i)
      if (const auto k = alone(unit, i); k < p)
        out[k].push_back({{unit.values[i], std::sqrt(unit.covariance(i, i))},
                          unit.shared.columns == 0 ? std::vector<double>() : row(unit.shared, i)});
  return out;
}

/// Variances of the results of each parameter: where the search for T begins.
Matrix first_spread(std::span<const ShownOfUnit> units) {
  std::vector<double> variances;
  for (const auto& values : values_alone(units)) {
    double sum = 0.0, squares = 0.0, own = 0.0;
    const auto count = static_cast<double>(values.size());
    for (const auto& value : values) sum += value.own.value, own += square(value.own.sd);
    for (const auto& value : values) squares += square(value.own.value - sum / count);
    const double variance = count > 1.0 ? squares / (count - 1.0) : 0.0;
    variances.push_back(std::max({variance, least_of_own * own / std::max(count, 1.0), 1e-300}));
  }
  return diagonal(variances);
}

Matrix most_likely_covariance(std::span<const ShownOfUnit> units, double shrinkage, int most_steps) {
  Matrix spread = first_spread(units);
  const Matrix least = 1e-8 * spread;  // a spread that dwindles stays positive
  for (int step = 0; step < most_steps; ++step) {
    Matrix next = next_spread(units, spread, shrinkage);
    double change = 0.0;
    for (std::size_t k = 0; k < spread.rows; ++k) {
      next(k, k) = std::max(next(k, k), least(k, k));
      change = std::max(change, std::abs(next(k, k) - spread(k, k)) / spread(k, k));
    }
    spread = std::move(next);
    if (change < last_change_of_spread) break;
  }
  return spread;
}

struct Predicted {
  double log_likelihood = 0.0;
  double inflation = 0.0;  ///< mean of D/p
};

/// How well the units of one fold are predicted by the others.
Predicted predicted(std::span<const ShownOfUnit> units, double shrinkage, std::size_t fold) {
  Predicted out;
  std::vector<ShownOfUnit> others;
  for (std::size_t u = 0; u < units.size(); ++u)
    if (u % folds != fold) others.push_back(units[u]);
  const Matrix spread = most_likely_covariance(others, shrinkage, 60);
  const auto at = mean_of(others, spread);
  for (std::size_t u = fold; u < units.size(); u += folds) {
    const auto& unit = units[u];
    const auto m = static_cast<double>(unit.values.size());
    if (unit.values.empty()) continue;
    const Matrix design = design_of(unit);
    const auto factor =
        cholesky(sandwich(unit.combinations, spread) + sandwich(design, at.covariance) + unit.covariance);
    if (!factor.positive) throw Error(Error::Kind::bad_data, "the covariance of a unit is not positive definite");
    const auto away = scaled_sum(unit.values, -1.0, design * at.unknowns);
    const double d = dot(away, solve(factor, away));
    out.log_likelihood -= 0.5 * (factor.log_determinant + d + m * std::log(two_pi));
    out.inflation += d / m / static_cast<double>(units.size());
  }
  return out;
}

/// Of each shrinkage that is tried; with many units the correlations need none.
std::vector<Predicted> predicted_by_shrinkage(std::span<const ShownOfUnit> units) {
  const std::size_t tried = units.size() > enough ? 1 : shrinkages.size();
  std::vector<Predicted> parts(tried * folds), out(tried);
  parallel_for(parts.size(), [&](std::size_t i) { parts[i] = predicted(units, shrinkages[i / folds], i % folds); });
  for (std::size_t i = 0; i < parts.size(); ++i) {
    out[i / folds].log_likelihood += parts[i].log_likelihood;
    out[i / folds].inflation += parts[i].inflation;
  }
  return out;
}

/// T with the standard deviations of (8.33) and its own correlations.
Matrix expected_of(std::span<const ShownOfUnit> units, const Matrix& spread) {
  std::vector<double> ratio;
  const auto values = values_alone(units);
  for (std::size_t k = 0; k < spread.rows; ++k)
    ratio.push_back(std::max(1.0, expected_spread(values[k]) / std::sqrt(spread(k, k))));
  return scaled_columns(scaled_rows(ratio, spread), ratio);
}

ShownOfUnit shown_of(const UnitVector& unit) {
  const auto which = seen(unit);
  return {chosen_rows(identity(unit.values.size()), which), part(unit.values, which), part(unit.covariance, which)};
}

}  // namespace

VectorPopulation vector_population(std::span<const ShownOfUnit> units) {
  require_vectors(units);
  const std::size_t p = units.front().combinations.columns;
  VectorPopulation out;
  const auto scores = predicted_by_shrinkage(units);
  const auto best = std::ranges::max_element(scores, {}, &Predicted::log_likelihood);
  out.shrinkage = shrinkages[static_cast<std::size_t>(best - scores.begin())];
  out.inflation = std::max(1.0, best->inflation);
  out.spread = most_likely_covariance(units, out.shrinkage, 500);
  out.expected_spread = expected_of(units, out.spread);
  const auto at = mean_of(units, out.expected_spread);
  out.mean = at.mean(p), out.mean_covariance = block(at.covariance, 0, p, 0, p);
  out.shared = -1.0 * block(at.covariance, 0, p, p, at.covariance.columns - p);
  out.units = units.size();
  return out;
}

VectorPopulation vector_population(std::span<const UnitVector> units) {
  std::vector<ShownOfUnit> shown;
  Problems problems;
  const auto p = units.empty() ? 0 : units.front().values.size();
  for (std::size_t u = 0; u < units.size(); ++u)
    if (units[u].values.size() == p && units[u].covariance.rows == p && units[u].covariance.columns == p)
      shown.push_back(shown_of(units[u]));
    else
      problems.push_back(say("unit {} has {} parameters, the first {}", u + 1, units[u].values.size(), p));
  try {
    auto out = vector_population(shown);
    if (problems.empty()) return out;
  } catch (const Error& error) {
    problems.insert(problems.end(), error.problems.begin(), error.problems.end());
  }
  throw Error(Error::Kind::bad_data, problems);
}

PopulationGain gain_of(const Matrix& prior, const std::vector<double>& mean, const ShownOfUnit& unit,
                       const Matrix& common) {
  const Matrix& a = unit.combinations;
  const Matrix both = common * transposed(a);
  PopulationGain out;
  out.departure = sandwich(a, prior) + unit.covariance - both - transposed(both);
  auto factor = cholesky(out.departure);
  for (std::size_t i = 0; i < out.departure.rows && !factor.positive; ++i) out.departure(i, i) *= 1.0 + added_variance;
  if (!factor.positive) factor = cholesky(out.departure);  // values that move together
  if (!factor.positive) throw Error(Error::Kind::bad_data, "the covariance of a unit is not positive definite");
  const auto away = scaled_sum(unit.values, -1.0, a * mean);
  out.solved = away.empty() ? away : solve(factor, away);
  out.distance = dot(away, out.solved);
  out.gain = away.empty() ? Matrix(mean.size(), 0) : transposed(solve(factor, a * prior - common));
  return out;
}

double belonging(double distance, std::size_t dimensions, double inflation, double freedom) {
  const auto m = static_cast<double>(dimensions);
  if (dimensions == 0) return 1.0;
  if (inflation > 1.0)
    freedom = std::min(freedom, std::max(least_freedom_of_belonging, 2.0 * inflation / (inflation - 1.0)));
  if (std::isinf(freedom)) return cdf(complement(boost::math::chi_squared(m), distance));
  return cdf(complement(boost::math::fisher_f(m, std::max(1.0, freedom)), distance / m));
}

VectorInPopulation vector_in_population(const VectorPopulation& population, const ShownOfUnit& unit,
                                        const Matrix& shared) {
  const auto p = population.mean.size(), m = unit.values.size();
  const Matrix& a = unit.combinations;
  if (a.columns != p || a.rows != m || unit.covariance.rows != m)
    throw Error(Error::Kind::bad_data, say("the unit has {} parameters, its population {}", a.columns, p));
  const Matrix prior = population.spread + population.mean_covariance;
  const Matrix common = shared.rows == m ? shared : Matrix(m, p);
  const auto gain = gain_of(prior, population.mean, unit, common);
  VectorInPopulation out;
  out.degrees_of_freedom = static_cast<double>(population.units) - 1.0;
  out.distance = gain.distance;
  out.values = scaled_sum(population.mean, 1.0, gain.gain * scaled_sum(unit.values, -1.0, a * population.mean));
  out.covariance = prior - gain.gain * (a * prior - common);
  out.belongs = belonging(out.distance, m, population.inflation);
  return out;
}

VectorInPopulation vector_in_population(const VectorPopulation& population, const UnitVector& unit,
                                        const Matrix& shared) {
  return vector_in_population(population, shown_of(unit), shared.rows == 0 ? shared : chosen_rows(shared, seen(unit)));
}

}  // namespace tumble
