#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "tumble/exchange/decision.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

/// In standard deviations of the production from its mean; beyond `reach` its density is below the smallest double.
constexpr double reach = 38.0;

struct Production {
  Population population;
  double sd;  ///< [u] of the measurement
  Tolerance acceptance;

  double place(double limit) const { return std::clamp((limit - population.mean) / population.sd, -reach, reach); }

  /// Probability that an instrument is accepted whose true value is z standard deviations from the mean.
  double accepted(double z) const {
    if (acceptance.empty()) return 0.0;
    const double truth = population.mean + z * population.sd;
    return normal_below((acceptance.upper - truth) / sd) - normal_below((acceptance.lower - truth) / sd);
  }

  /// Ends of the pieces of a quadrature: the integrand falls within a few sd of the measurement at each limit.
  std::vector<double> pieces(double from, double to) const {
    std::vector<double> ends{from, to};
    for (const double at : {from, place(acceptance.lower), place(acceptance.upper), to})
      for (const double near : {-6.0, -2.0, 0.0, 2.0, 6.0})
        ends.push_back(std::clamp(at + near * sd / population.sd, from, to));
    for (double at = -8.0; at <= 8.0; at += 2.0) ends.push_back(std::clamp(at, from, to));
    std::sort(ends.begin(), ends.end());
    return ends;
  }
};

/// Integral of density times probability(z) from `from` to `to`.
template <class Probability>
double integral(const Production& production, const Probability& probability, double from, double to) {
  if (from >= to) return 0.0;
  const auto integrand = [&](double z) { return std::exp(-0.5 * z * z) / std::sqrt(two_pi) * probability(z); };
  const std::vector<double> ends = production.pieces(from, to);
  double sum = 0.0;
  for (std::size_t i = 1; i < ends.size(); ++i)
    if (ends[i - 1] < ends[i])
      sum += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(integrand, ends[i - 1], ends[i], 5, 1e-12);
  return sum;
}

}  // namespace

GlobalRisk global_risk(const Population& population, double sd, const Tolerance& tolerance,
                       const Tolerance& acceptance) {
  assert(population.sd >= 0.0 && sd > 0.0);
  const Production production{population, sd, acceptance};
  if (population.sd == 0.0) {
    const double accepted = production.accepted(0.0);
    return tolerance.holds(population.mean) ? GlobalRisk{0.0, 1.0 - accepted} : GlobalRisk{accepted, 0.0};
  }
  const auto accepted = [&](double z) { return production.accepted(z); };
  const auto rejected = [&](double z) { return 1.0 - production.accepted(z); };
  const double low = production.place(tolerance.lower), high = production.place(tolerance.upper);
  return {integral(production, accepted, -reach, low) + integral(production, accepted, high, reach),
          integral(production, rejected, low, high)};
}

GlobalRisk global_risk(std::span<const Population> populations, double sd, const Tolerance& tolerance,
                       const Tolerance& acceptance) {
  GlobalRisk mean{};
  for (const Population& population : populations) {
    const GlobalRisk one = global_risk(population, sd, tolerance, acceptance);
    mean.consumer += one.consumer / static_cast<double>(populations.size());
    mean.producer += one.producer / static_cast<double>(populations.size());
  }
  return mean;
}

Tolerance acceptance_of_fleet(std::span<const Population> populations, double sd, const Tolerance& tolerance,
                              double target) {
  assert(!populations.empty() && sd > 0.0 && target > 0.0 && target < 1.0);
  double width = sd;  // far outside of the production and of what the measurement adds
  for (const Population& population : populations)
    for (const double limit : {tolerance.lower, tolerance.upper})
      if (std::isfinite(limit)) width = std::max({width, population.sd, std::abs(population.mean - limit)});
  const auto moved = [&](double guard) { return Tolerance{tolerance.lower + guard, tolerance.upper - guard}; };
  const auto excess = [&](double guard) {
    return global_risk(populations, sd, tolerance, moved(guard)).consumer - target;
  };
  const double least = -100.0 * width;
  const double most = tolerance.two_sided() ? 0.5 * (tolerance.upper - tolerance.lower) : 100.0 * width;
  if (excess(least) <= 0.0) return {};
  std::uintmax_t steps = 100;
  const auto close = [width](double a, double b) { return std::abs(b - a) < 1e-9 * width; };
  return moved(boost::math::tools::toms748_solve(excess, least, most, close, steps).second);
}

}  // namespace tumble
