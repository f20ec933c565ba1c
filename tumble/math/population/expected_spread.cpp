#include "tumble/math/population/expected_spread.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Restricted log likelihood at variance t: the mean has a flat prior, the common errors have variance 1.
double log_likelihood_at(std::span<const KeyedUnitValue> units, double t) {
  const std::size_t unknowns = 1 + units.front().shared.size();
  Matrix information(unknowns, unknowns);
  std::vector<double> right(unknowns, 0.0), row(unknowns, 1.0);
  for (std::size_t k = 1; k < unknowns; ++k) information(k, k) = 1.0;
  double sum = 0.0;
  for (const auto& unit : units) {
    const double weight = 1.0 / (t + square(unit.own.sd));
    std::ranges::copy(unit.shared, row.begin() + 1);
    add_square(information, weight, row);
    for (std::size_t k = 0; k < unknowns; ++k) right[k] += weight * unit.own.value * row[k];
    sum += std::log(weight) - weight * square(unit.own.value);
  }
  const auto factor = cholesky(information);
  if (!factor.positive) return -INFINITY;
  return 0.5 * (sum - factor.log_determinant + dot(right, solve(factor, right)));
}

/// Mean of all, and a length that the spread is compared with.
std::pair<double, double> centre_and_scale(std::span<const KeyedUnitValue> units) {
  std::vector<double> sds;
  double mean = 0.0, squares = 0.0;
  const auto n = static_cast<double>(units.size());
  for (const auto& unit : units) sds.push_back(unit.own.sd), mean += unit.own.value / n;
  for (const auto& unit : units) squares += square(unit.own.value - mean) / (n - 1.0);
  return {mean, median(std::move(sds)) + std::sqrt(squares)};
}

}  // namespace

double expected_spread(std::span<const KeyedUnitValue> units) {
  using Rule = boost::math::quadrature::gauss<double, 64>;
  if (units.size() < fewest_units_of_population)
    throw Error(Error::Kind::bad_data, say("a prior needs at least five units; here {} given", units.size()));
  std::vector<UnitValue> values;
  for (const auto& unit : units) values.push_back(unit.own);
  require_population(values);
  const auto [centre, scale] = centre_and_scale(units);
  if (!(scale > 0.0)) return 0.0;
  std::vector<KeyedUnitValue> standard(units.begin(), units.end());
  for (auto& unit : standard) {
    unit.own = {(unit.own.value - centre) / scale, unit.own.sd / scale};
    for (double& shift : unit.shared) shift /= scale;
  }
  std::vector<double> taus, logs;
  const auto add = [&](double node, double weight) {  // tau = x/(1 - x); flat in tau^2
    const double x = 0.5 * (1.0 + node), tau = x / (1.0 - x);
    taus.push_back(tau);
    logs.push_back(std::log(weight * tau / square(1.0 - x)) + log_likelihood_at(standard, square(tau)));
  };
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    add(Rule::abscissa()[i], Rule::weights()[i]);
    add(-Rule::abscissa()[i], Rule::weights()[i]);
  }
  const double most = std::ranges::max(logs);
  double sum = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < taus.size(); ++i)
    sum += std::exp(logs[i] - most), mean += taus[i] * std::exp(logs[i] - most);
  return scale * mean / sum;
}

}  // namespace tumble
