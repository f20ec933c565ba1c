#include "tumble/math/population/new_unit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <vector>

#include "tumble/math/bisection.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/population/expected_spread.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// One possible population: its variance t with weight, mean and the variance of that.
struct Possible {
  double t, log_weight, mean, mean_variance;
  double weight = 0.0;
};

double log_normal_density(double x, double variance) { return -0.5 * (std::log(two_pi * variance) + x * x / variance); }

double scale_of(std::span<const UnitValue> units) {
  std::vector<double> sds;
  double mean = 0.0, squares = 0.0;
  for (const auto& unit : units) sds.push_back(unit.sd), mean += unit.value / static_cast<double>(units.size());
  for (const auto& unit : units) squares += square(unit.value - mean) / (static_cast<double>(units.size()) - 1.0);
  return median(std::move(sds)) + std::sqrt(squares);
}

/// tau = s x/(1 - x) at the nodes in x; the prior is flat in t = tau^2.
std::vector<Possible> populations(std::span<const UnitValue> units) {
  using Rule = boost::math::quadrature::gauss<double, 64>;
  const double scale = scale_of(units);
  std::vector<Possible> out;
  const auto add = [&](double node, double weight) {
    const double x = 0.5 * (1.0 + node), tau = scale * x / (1.0 - x);
    const double jacobian = 2.0 * tau * scale / square(1.0 - x);
    const auto at = mean_at_spread(units, tau * tau);
    out.push_back({tau * tau, std::log(0.5 * weight * jacobian) + at.log_likelihood, at.mean, 1.0 / at.weight});
  };
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
    add(Rule::abscissa()[i], Rule::weights()[i]);
    add(-Rule::abscissa()[i], Rule::weights()[i]);
  }
  return out;
}

void normalise(std::vector<Possible>& all) {
  const double most = std::ranges::max(all, {}, &Possible::log_weight).log_weight;
  double sum = 0.0;
  for (auto& one : all) sum += one.weight = std::exp(one.log_weight - most);
  for (auto& one : all) one.weight /= sum;
}

struct Part {
  double weight, mean, variance;
};

double below(const std::vector<Part>& parts, double x) {
  double sum = 0.0;
  for (const auto& part : parts) sum += part.weight * normal_below((x - part.mean) / std::sqrt(part.variance));
  return sum;
}

/// Mean and variance of the mixture.
Part moments(const std::vector<Part>& parts) {
  Part out{1.0, 0.0, 0.0};
  for (const auto& part : parts) out.mean += part.weight * part.mean;
  for (const auto& part : parts) out.variance += part.weight * (part.variance + square(part.mean - out.mean));
  return out;
}

double quantile_of(const std::vector<Part>& parts, double probability) {
  const auto whole = moments(parts);
  double low = whole.mean, high = whole.mean, step = std::sqrt(whole.variance);
  while (below(parts, low) > probability) low -= step;
  while (below(parts, high) < probability) high += step;
  constexpr int halvings = 44;  // to 1e-12 of the standard deviation
  return bisected(low, high, halvings, [&](double value) { return below(parts, value) < probability; }).middle();
}

/// (8.13) for one parameter, given the population.
Part posterior(const Possible& one, const UnitValue& unit) {
  const double prior = one.t + one.mean_variance, share = prior / (prior + square(unit.sd));
  return {one.weight, one.mean + share * (unit.value - one.mean), prior * (1.0 - share)};
}

}  // namespace

UnitInPopulation unit_in_population(std::span<const UnitValue> units, const UnitValue& unit) {
  if (units.size() < fewest_units_of_population)
    throw Error(Error::Kind::bad_data,
                say("a population of {} units says too little of a new one: at least five are needed", units.size()));
  if (!std::isfinite(unit.value) || !(unit.sd > 0.0) || !std::isfinite(unit.sd))
    throw Error(Error::Kind::bad_data, "a new unit needs a value and a standard uncertainty above zero");
  static_cast<void>(spread_of_units(units));  // its problems
  auto all = populations(units);
  UnitInPopulation out;
  normalise(all);
  std::vector<Part> expected, posteriors;
  for (const auto& one : all) expected.push_back({one.weight, one.mean, one.t + one.mean_variance + square(unit.sd)});
  const double cumulative = below(expected, unit.value);
  out.belongs = 2.0 * std::min(cumulative, 1.0 - cumulative);
  for (auto& one : all)
    one.log_weight += log_normal_density(unit.value - one.mean, one.t + one.mean_variance + square(unit.sd));
  normalise(all);
  for (const auto& one : all) {
    posteriors.push_back(posterior(one, unit));
    out.spread += one.weight * std::sqrt(one.t);
  }
  const auto whole = moments(posteriors);
  out.value = whole.mean, out.sd = std::sqrt(whole.variance);
  out.lower = quantile_of(posteriors, below_two_sided_95), out.upper = quantile_of(posteriors, two_sided_95);
  return out;
}

}  // namespace tumble
