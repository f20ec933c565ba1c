#include "tumble/math/population/capability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

void require_limits(const Tolerance& limits) {
  const bool some = std::isfinite(limits.lower) || std::isfinite(limits.upper);
  if (!some || !(limits.lower < limits.upper))
    throw Error(Error::Kind::bad_input,
                say("capability needs limits of which at least one is a number and the lower is below the "
                    "upper; here {} and {} given",
                    limits.lower, limits.upper));
}

constexpr double unlimited = std::numeric_limits<double>::infinity();

struct Interval {
  double lower = unlimited, upper = unlimited;
};

/// 95 % of the indices of populations, with respect to one limit. The smaller of two limits has no interval of its own:
/// an error of the mean, of either sign, makes it smaller, and a mean in the middle would never be held.
Interval index_interval(std::span<const Population> populations, const Tolerance& limit) {
  if (!std::isfinite(limit.lower) && !std::isfinite(limit.upper)) return {};
  std::vector<double> indices;
  indices.reserve(populations.size());
  for (const auto& one : populations) indices.push_back(capability_index(one, limit));
  std::ranges::sort(indices);
  const std::size_t tail = indices.size() / 40;
  return {indices[tail], indices[indices.size() - 1 - tail]};
}

double spread_of_results(std::span<const UnitValue> units) {
  const auto n = static_cast<double>(units.size());
  double mean = 0.0, squares = 0.0;
  for (const auto& unit : units) mean += unit.value / n;
  for (const auto& unit : units) squares += square(unit.value - mean) / (n - 1.0);
  return std::sqrt(squares);
}

}  // namespace

double capability_index(const Population& population, const Tolerance& limits) {
  const double room = std::min(limits.upper - population.mean, population.mean - limits.lower);
  if (population.sd == 0.0) return std::copysign(std::numeric_limits<double>::infinity(), room);
  return room / (3.0 * population.sd);
}

std::vector<Population> possible_populations(std::span<const UnitValue> units, std::size_t count) {
  require_population(units);
  const double freedom = static_cast<double>(units.size()) - 1.0;
  const RandomStream random(1);
  std::vector<Population> out;
  double t = 0.0;
  for (std::size_t i = count; i-- > 0;) {  // Q falls, t grows: each root is near the one before
    t = spread_at_scatter(units,
                          chi_square_quantile((static_cast<double>(i) + 0.5) / static_cast<double>(count), freedom), t);
    const auto at = mean_at_spread(units, t);
    out.push_back({at.mean + random.normal(i) / std::sqrt(at.weight), std::sqrt(t)});
  }
  return out;
}

Capability capability_of(std::span<const UnitValue> units, const Tolerance& limits, double shared_sd) {
  require_limits(limits);
  const auto spread = spread_of_units(units);
  Capability out;
  out.index = capability_index({spread.mean, spread.sd}, limits);
  out.measured = capability_index({spread.mean, spread_of_results(units)}, limits);
  auto populations = possible_populations(units);
  const RandomStream random(2);
  for (std::size_t i = 0; i < populations.size(); ++i) populations[i].mean += shared_sd * random.normal(i);
  const Interval below = index_interval(populations, {limits.lower, unlimited});
  const Interval above = index_interval(populations, {-unlimited, limits.upper});
  out.lower = std::min(below.lower, above.lower), out.upper = std::min(below.upper, above.upper);
  return out;
}

}  // namespace tumble
