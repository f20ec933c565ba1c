#include "tumble/methods/rlg_north_finder/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr double follows_sd = 5.0;  ///< [sd] of a scale factor, below which the output does not follow its input

constexpr std::size_t count = outputs * per_output;

/// Index of each coefficient in the solution. Throws for those that the solution lacks.
std::vector<std::size_t> places_of(const linear::JointSolution& solution) {
  std::vector<std::size_t> places;
  Problems problems;
  for (const auto& parameter : wanted()) {
    const auto& columns = solution.all.columns;
    const auto column = std::ranges::find(columns, parameter.name, &Term::name);
    if (column == columns.end()) problems.push_back(say("the test does not show {}", parameter.name));
    places.push_back(static_cast<std::size_t>(column - columns.begin()));
  }
  for (const auto& finding : solution.all.findings)
    if (!problems.empty()) problems.push_back(said_of(finding));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  return places;
}

}  // namespace

double freedom_of(const MixedFit& fit, std::size_t index) {
  std::vector<double> unit(fit.parameters.size(), 0.0);
  unit[index] = 1.0;
  return degrees_of_freedom(fit, unit);
}

Estimate estimate_from(const std::vector<double>& values, const std::vector<double>& freedom,
                       const std::vector<ErrorLine>& lines) {
  Estimate estimate;
  for (std::size_t p = 0; p < count; ++p) {
    const Wanted& parameter = wanted()[p];
    estimate.parameters.push_back(
        {parameter.name, parameter.symbol, Unit::parse(parameter.unit), values[p], parameter.description, freedom[p]});
    estimate.parameters.back().channels = {role_of(parameter.output)};
  }
  settle(estimate, lines);
  gather_small(estimate);
  return estimate;
}

Estimate least_squares_estimate(const linear::JointSolution& solution) {
  const auto places = places_of(solution);
  const MixedFit& fit = solution.all.fit;
  Matrix jacobian(count, fit.parameters.size());
  std::vector<double> values, freedom;
  for (std::size_t p = 0; p < count; ++p) {
    const std::size_t scale = places[p - p % per_output];
    const double k = fit.parameters[scale], b = fit.parameters[places[p]];
    const double sd = std::sqrt(fit.covariance(scale, scale));
    if (!std::isfinite(k) || !(std::abs(k) > follows_sd * sd))
      throw Error(Error::Kind::bad_data, say("{} does not follow what it should measure: its scale factor is zero "
                                             "within its uncertainty",
                                             Name{role_of(wanted()[p].output)}));
    jacobian(p, places[p]) = p % per_output == 0 ? 1.0 : 1.0 / k;
    if (p % per_output != 0) jacobian(p, scale) = -b / (k * k);
    values.push_back(p % per_output == 0 ? k : b / k);
    freedom.push_back(degrees_of_freedom(fit, row(jacobian, p)));
  }
  Estimate estimate = estimate_from(values, freedom, carried(jacobian, lines_of(fit.sources)));
  estimate.fit = {solution.all.observations, fit.degrees_of_freedom, fit.chi_square, fit.condition};
  estimate.findings = solution.all.findings;
  return estimate;
}

}  // namespace tumble::rlg_north_finder
