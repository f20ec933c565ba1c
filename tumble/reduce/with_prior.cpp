#include "tumble/reduce/with_prior.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/population/vector_population.hpp"
#include "tumble/math/square.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/prior_rows.hpp"
#include "tumble/reduce/rig_keys.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double greatest_freedom = 1e6;  ///< more is infinite: the quantiles agree to 1e-6

/// Each test at half of 1 %: one of all parameters together, one of the worst.
constexpr double least_belonging = 0.005;

/// Names, numbers and degrees of freedom of the result's rows, in the order [rows of the population; other rows].
struct Rows {
  std::vector<std::size_t> of_result;  ///< numbers of parameters of the result
  std::size_t known = 0;               ///< how many of them the population speaks of
  Matrix combinations;                 ///< [known x p]
  Matrix weights;                      ///< [other x p], of the population's terms in the other rows
};

Rows rows_of(const Estimate& result, const Estimate& population) {
  Rows rows;
  std::vector<std::size_t> others;
  std::vector<std::vector<double>> known, weights;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    if (!prior_rows::is_normal(result, i)) continue;
    auto row = prior_rows::row_of(result.parameters[i], population.parameters);
    if (row.known) {
      rows.of_result.push_back(i);
      known.push_back(std::move(row.weights));
    } else {
      others.push_back(i);
      weights.push_back(std::move(row.weights));
    }
  }
  rows.known = known.size();
  rows.of_result.insert(rows.of_result.end(), others.begin(), others.end());
  const auto matrix = [&](const std::vector<std::vector<double>>& from) {
    Matrix out(from.size(), population.parameters.size());
    for (std::size_t i = 0; i < from.size(); ++i)
      for (std::size_t k = 0; k < out.columns; ++k) out(i, k) = from[i][k];
    return out;
  };
  rows.combinations = matrix(known);
  rows.weights = matrix(weights);
  return rows;
}

/// The rows of a result, as an estimate: its lines, with those of the population that are the same errors.
Estimate part_of(const Estimate& estimate, const std::vector<std::size_t>& which) {
  Estimate out;
  for (const auto i : which) out.parameters.push_back(estimate.parameters[i]);
  for (const auto& line : estimate.budget)
    out.budget.push_back({line.source, line.key, chosen_rows(line.factor, which)});
  out.covariance = covariance_of(out.budget, which.size());
  return out;
}

/// The population without parameters that the result has under another meaning.
Estimate used_part(const Estimate& population, const Estimate& result) {
  std::vector<std::size_t> which;
  for (std::size_t k = 0; k < population.parameters.size(); ++k) {
    const auto* same = find_parameter(result, population.parameters[k].name);
    if (!same || prior_rows::row_of(*same, population.parameters).known) which.push_back(k);
  }
  return part_of(population, which);
}

bool same_errors(const Contribution& a, const Contribution& b) {
  return !a.key.empty() && a.source == b.source && a.key == b.key && a.factor.columns == b.factor.columns;
}

/// K [m x p]: covariance of the errors of a result with those of the population's means.
Matrix common_of(const Estimate& result, const Estimate& population) {
  Matrix out(result.parameters.size(), population.parameters.size());
  for (const auto& a : result.budget)
    for (const auto& b : population.budget)
      if (same_errors(a, b)) out += a.factor * transposed(b.factor);
  return out;
}

/// A line of the population whose error the result has with another number of draws is its own.
std::vector<ErrorLine> lines_of_population(const Estimate& population, const Estimate& result) {
  std::vector<ErrorLine> lines;
  for (const auto& line : population.budget) {
    const auto clashes = [&](const Contribution& other) {
      return other.source == line.source && other.key == line.key && !same_errors(line, other);
    };
    const bool alone = std::ranges::any_of(result.budget, clashes);
    lines.push_back({line.source, line.factor, alone ? std::string() : line.key, {}});
  }
  return lines;
}

std::vector<ErrorLine> lines_of_result(const Estimate& result) {
  std::vector<ErrorLine> lines;
  for (const auto& line : result.budget) lines.push_back({line.source, line.factor, line.key, {}});
  return lines;
}

/// The estimate with prior as a linear function of result y and means m.
struct Maps {
  Matrix of_result, of_means;  ///< [q x m], [q x p]
};

Maps maps_of(const Rows& rows, const Estimate& result, const Matrix& common, const PopulationGain& gain) {
  const std::size_t p = rows.combinations.columns, r = rows.known, x = rows.weights.rows, m = r + x;
  Maps maps{Matrix(p + x, m), Matrix(p + x, p)};
  const Matrix means = identity(p) - gain.gain * rows.combinations;
  set_block(maps.of_result, 0, 0, gain.gain);
  set_block(maps.of_means, 0, 0, means);
  if (x == 0) return maps;
  // what the rows of the population say of the errors of the other rows
  const Matrix with_known =
      block(result.covariance, r, x, 0, r) - block(common, r, x, 0, p) * transposed(rows.combinations);
  const Matrix h = r == 0 ? Matrix(x, 0) : transposed(solve_symmetric(gain.departure, transposed(with_known)));
  set_block(maps.of_result, p, 0, -1.0 * (rows.weights * gain.gain) - h);
  set_block(maps.of_result, p, r, identity(x));
  set_block(maps.of_means, p, 0, h * rows.combinations - rows.weights * means);
  return maps;
}

/// Variance of row i of a map with this covariance.
double variance_of(const Matrix& map, std::size_t i, const Matrix& covariance) {
  return quadratic_form(row(map, i), covariance);
}

double least_freedom(const Estimate& result, std::size_t known) {
  double least = INFINITY;
  for (std::size_t i = 0; i < known; ++i) least = std::min(least, result.parameters[i].degrees_of_freedom);
  return least;
}

/// Welch and Satterthwaite over the two parts.
double freedom_of(double all, double own, double own_freedom, double prior, double units) {
  const double fourth = square(own) / own_freedom + square(prior) / (units - 1.0);
  return fourth > 0.0 ? std::max(1.0, square(all) / fourth) : INFINITY;
}

/// Smallest p-value of a single row, times the number of rows.
double worst_row(const Estimate& result, const Rows& rows, const Estimate& population, const PopulationGain& gain,
                 double units) {
  double least = 1.0;
  const Matrix prior = sandwich(rows.combinations, population.covariance);
  for (std::size_t i = 0; i < rows.known; ++i) {
    double away = result.parameters[i].value;
    for (std::size_t k = 0; k < rows.combinations.columns; ++k)
      away -= rows.combinations(i, k) * population.parameters[k].value;
    const double variance = gain.departure(i, i);
    const double freedom = std::min(
        greatest_freedom,
        freedom_of(variance, result.covariance(i, i), result.parameters[i].degrees_of_freedom, prior(i, i), units));
    const double p = 2.0 * cdf(complement(boost::math::students_t(freedom), std::abs(away) / std::sqrt(variance)));
    least = std::min(least, p * static_cast<double>(rows.known));
  }
  return least;
}

/// Parameters of the estimate with prior: all of the population, then the other rows.
std::vector<Parameter> parameters_of(const Estimate& population, const Estimate& result, const Rows& rows) {
  std::vector<Parameter> all = population.parameters;
  for (auto& parameter : all)
    if (const auto* own = find_parameter(result, parameter.name)) parameter.unit = own->unit;
  for (std::size_t i = rows.known; i < result.parameters.size(); ++i) {
    all.push_back(result.parameters[i]);
    std::erase_if(all.back().contains,
                  [&](const Parameter::Contained& term) { return find_parameter(population, term.name) != nullptr; });
  }
  return all;
}

Estimate updated(const Estimate& result, const Rows& rows, const Estimate& population, const Matrix& common,
                 const PopulationGain& gain, double units) {
  const auto maps = maps_of(rows, result, common, gain);
  Estimate out;
  out.parameters = parameters_of(population, result, rows);
  std::vector<double> y, m;
  for (const auto& parameter : result.parameters) y.push_back(parameter.value);
  for (const auto& parameter : population.parameters) m.push_back(parameter.value);
  const auto values = scaled_sum(maps.of_result * y, 1.0, maps.of_means * m);
  auto lines = carried(maps.of_result, lines_of_result(result));
  for (auto& line : carried(maps.of_means, lines_of_population(population, result))) lines.push_back(std::move(line));
  settle(out, lines);
  const double least = least_freedom(result, rows.known);
  for (std::size_t i = 0; i < out.parameters.size(); ++i) {
    const auto* own = find_parameter(result, out.parameters[i].name);
    out.parameters[i].value = values[i];
    out.parameters[i].degrees_of_freedom =
        freedom_of(out.covariance(i, i), variance_of(maps.of_result, i, result.covariance),
                   own ? own->degrees_of_freedom : least, variance_of(maps.of_means, i, population.covariance), units);
  }
  return out;
}

/// Parameters of the result first, in its order, then those that the population adds.
Estimate in_order_of(const Estimate& result, const Estimate& with_prior) {
  std::vector<std::size_t> order;
  for (const auto& parameter : result.parameters)
    for (std::size_t i = 0; i < with_prior.parameters.size(); ++i)
      if (with_prior.parameters[i].name == parameter.name) order.push_back(i);
  for (std::size_t i = 0; i < with_prior.parameters.size(); ++i)
    if (std::ranges::find(order, i) == order.end()) order.push_back(i);
  return part_of(with_prior, order);
}

void refuse_other_dimensions(const Estimate& result, const Estimate& population) {
  Problems problems;
  for (const auto& parameter : population.parameters) {
    const auto* own = find_parameter(result, parameter.name);
    if (own && own->unit.dimension() != parameter.unit.dimension())
      problems.push_back(say("{} is in {} [{}], but in {} [{}] in the population that is its prior",
                             Name{parameter.name}, Name{own->unit.text()}, Name{name(own->unit.dimension())},
                             Name{parameter.unit.text()}, Name{name(parameter.unit.dimension())}));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

}  // namespace

Problems problems_of_prior(const Estimate& population, const std::string& model, const std::string& method) {
  Problems problems;
  if (!population.population) {
    problems.emplace_back(
        "is no population: `tumble population MODEL -o FILE` writes one, and a result with a prior holds one");
    return problems;
  }
  if (!model.empty() && population.instrument_model != model)
    problems.push_back(say("is of units of the model '{}', the plan is of a '{}'", population.instrument_model, model));
  if (population.population->method != method)
    problems.push_back(
        say("is made from results of {}, the plan's method is {}", Name{population.population->method}, Name{method}));
  if (population.parameters.empty()) problems.emplace_back("has no parameters");
  return problems;
}

PriorUse with_population(const Estimate& given, const Estimate& whole_population, bool certain) {
  refuse_other_dimensions(given, whole_population);
  const Estimate whole_result = rig_keys::with_keys_of(given, whole_population);
  const Estimate population = used_part(whole_population, whole_result);
  const auto rows = rows_of(whole_result, population);
  const Estimate result = part_of(whole_result, rows.of_result);
  const double units = static_cast<double>(whole_population.population->units);
  const Matrix common = common_of(result, population);
  std::vector<std::size_t> known(rows.known);
  for (std::size_t i = 0; i < known.size(); ++i) known[i] = i;
  std::vector<double> values, means;
  for (const auto i : known) values.push_back(result.parameters[i].value);
  for (const auto& parameter : population.parameters) means.push_back(parameter.value);
  const Matrix covariance = chosen_columns(chosen_rows(result.covariance, known), known);
  const auto gain =
      gain_of(population.covariance, means, {rows.combinations, values, covariance}, chosen_rows(common, known));
  PriorUse use;
  use.population = std::make_shared<const Estimate>(whole_population);
  if (!certain) {
    use.belongs =
        belonging(gain.distance, rows.known, whole_population.population->inflation, least_freedom(result, rows.known));
    use.belongs_by_one = worst_row(result, rows, population, gain, units);
    if (use.belongs < least_belonging || use.belongs_by_one < least_belonging) return use;
  }
  use.with_prior = std::make_shared<const Estimate>(
      in_order_of(whole_result, updated(result, rows, population, common, gain, units)));
  return use;
}

double conditional_coverage(double ratio, double away) {
  const double b = 1.0 / (1.0 + square(ratio)), half = 1.959964 * std::sqrt(1.0 - b), bias = b * away * ratio;
  return normal_below((half + bias) / (1.0 - b)) - normal_below((bias - half) / (1.0 - b));
}

}  // namespace tumble
