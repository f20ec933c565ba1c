#include "tumble/methods/rlg_north_finder/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::rlg_north_finder {
namespace {

constexpr std::size_t count = outputs * per_output;

/// J C J'
Matrix carried(const Matrix& jacobian, const Matrix& covariance) {
  Matrix half(jacobian.rows, covariance.columns), out(jacobian.rows, jacobian.rows);
  for (std::size_t i = 0; i < half.rows; ++i)
    for (std::size_t k = 0; k < covariance.rows; ++k)
      if (const double j = jacobian(i, k); j != 0.0)
        for (std::size_t l = 0; l < covariance.columns; ++l) half(i, l) += j * covariance(k, l);
  for (std::size_t i = 0; i < out.rows; ++i)
    for (std::size_t k = 0; k < out.rows; ++k)
      for (std::size_t l = 0; l < covariance.columns; ++l) out(i, k) += half(i, l) * jacobian(k, l);
  return out;
}

/// Where each coefficient stands in the solution. Throws for those left out.
std::vector<std::size_t> places_of(const linear::JointSolution& solution) {
  std::vector<std::size_t> places;
  std::vector<std::string> problems;
  for (const auto& one : wanted()) {
    const auto& columns = solution.all.columns;
    const auto found = std::ranges::find(columns, one.name, &Term::name);
    if (found == columns.end()) problems.push_back(fmt::format("the test does not show {}", one.name));
    places.push_back(static_cast<std::size_t>(found - columns.begin()));
  }
  for (const auto& finding : solution.all.findings)
    if (!problems.empty()) problems.push_back(finding.message);
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
                       const std::vector<SourceCovariance>& sources) {
  Estimate estimate;
  estimate.method = "rlg_north_finder";
  for (std::size_t p = 0; p < count; ++p) {
    const Wanted& one = wanted()[p];
    estimate.parameters.push_back(
        {one.name, one.symbol, Unit::parse(one.unit), values[p], one.description, freedom[p]});
  }
  estimate.covariance = Matrix(count, count);
  for (const auto& source : sources)
    for (std::size_t k = 0; k < count * count; ++k) estimate.covariance.values[k] += source.covariance.values[k];
  for (const auto& source : sources) {
    bool small = true;
    for (std::size_t p = 0; p < count; ++p) small = small && source.covariance(p, p) < 1e-4 * estimate.covariance(p, p);
    const std::string name = small ? "all other sources" : source.source;
    auto line = std::ranges::find(estimate.budget, name, &Contribution::source);
    if (line == estimate.budget.end()) line = estimate.budget.insert(line, {name, std::vector<double>(count, 0.0)});
    for (std::size_t p = 0; p < count; ++p) line->variance[p] += std::max(0.0, source.covariance(p, p));
  }
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
    if (!std::isfinite(k) || !(std::abs(k) > 5.0 * sd))
      throw Error(Error::Kind::bad_data, fmt::format("{} follows nothing that was felt: its scale factor is zero "
                                                     "within its uncertainty",
                                                     role_of(wanted()[p].output)));
    jacobian(p, places[p]) = p % per_output == 0 ? 1.0 : 1.0 / k;
    if (p % per_output != 0) jacobian(p, scale) = -b / (k * k);
    values.push_back(p % per_output == 0 ? k : b / k);
    std::vector<double> gradient(fit.parameters.size());
    for (std::size_t j = 0; j < gradient.size(); ++j) gradient[j] = jacobian(p, j);
    freedom.push_back(degrees_of_freedom(fit, gradient));
  }
  std::vector<SourceCovariance> sources;
  for (const auto& source : fit.sources) sources.push_back({source.source, carried(jacobian, source.covariance)});
  Estimate estimate = estimate_from(values, freedom, sources);
  estimate.fit = {solution.all.observations, fit.degrees_of_freedom, fit.chi_square, fit.condition};
  estimate.findings = solution.all.findings;
  return estimate;
}

}  // namespace tumble::rlg_north_finder
