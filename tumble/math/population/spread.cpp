#include "tumble/math/population/spread.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>

#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr double least_spread = 1e-18;  ///< [1] of the largest, squared: where Newton's steps begin
constexpr int most_steps_of_spread = 200;
constexpr double last_growth = 1e-14;  ///< [1] rounding

/// A spread that is larger than any the data allow [u].
double largest_spread(std::span<const UnitValue> units) {
  const auto [low, high] = std::ranges::minmax(units, {}, &UnitValue::value);
  double most = high.value - low.value;
  for (const auto& unit : units) most = std::max(most, unit.sd);
  return most;
}

/// Where no spread is most likely: t [u^2] up to which the restricted likelihood falls by half the 95 % quantile of
/// chi-square with one degree of freedom. Q(t) alone gives no limit there: it may be below its quantile at 0 already.
double likely_up_to(std::span<const UnitValue> units) {
  constexpr double fall = 0.5 * 3.841458820694124;
  const double scale = largest_spread(units);
  if (scale == 0.0) return 0.0;
  const double at_zero = mean_at_spread(units, 0.0).log_likelihood;
  const auto beyond = [&](double sd) { return at_zero - mean_at_spread(units, square(sd)).log_likelihood > fall; };
  double low = 0.0, high = scale;
  while (!beyond(high)) low = high, high *= 2.0;
  for (int i = 0; i < most_steps_of_spread && high - low > 1e-9 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (beyond(middle) ? high : low) = middle;
  }
  return square(high);
}

/// Q'(t) [1/u^2], < 0.
double slope_of_scatter(std::span<const UnitValue> units, double t, double mean) {
  double slope = 0.0;
  for (const auto& unit : units) slope -= square((unit.value - mean) / (t + square(unit.sd)));
  return slope;
}

}  // namespace

MeanAtSpread mean_at_spread(std::span<const UnitValue> units, double t) {
  MeanAtSpread out;
  double sum = 0.0, logarithms = 0.0;
  for (const auto& unit : units) {
    const double weight = 1.0 / std::max(t + square(unit.sd), 1e-300);
    out.weight += weight;
    sum += weight * unit.value;
    logarithms += std::log(weight);
  }
  out.mean = sum / out.weight;
  for (const auto& unit : units) out.q += square(unit.value - out.mean) / std::max(t + square(unit.sd), 1e-300);
  out.log_likelihood = 0.5 * (logarithms - std::log(out.weight) - out.q);
  return out;
}

double most_likely_spread(std::span<const UnitValue> units) {
  // tau = s x/(1 - x) takes all of [0, inf) to [0, 1); the likelihood may have two maxima, hence the grid.
  const double scale = largest_spread(units);
  if (scale == 0.0) return 0.0;
  const auto t_of = [scale](double x) { return square(scale * x / (1.0 - x)); };
  const auto cost = [&](double x) { return -mean_at_spread(units, t_of(x)).log_likelihood; };
  constexpr int cells = 64;
  int best = 0;
  double least = cost(0.0);
  for (int i = 1; i < cells; ++i)
    if (const double value = cost(static_cast<double>(i) / cells); value < least) least = value, best = i;
  const double low = std::max(0, best - 1) / static_cast<double>(cells);
  const double high = std::min(cells - 1, best + 1) / static_cast<double>(cells);
  const auto [x, value] = boost::math::tools::brent_find_minima(cost, low, high, 40);
  return cost(0.0) <= value ? 0.0 : t_of(x);
}

void require_population(std::span<const UnitValue> units) {
  Problems problems;
  if (units.size() < 3) problems.push_back(say("a population needs at least three units; here {} given", units.size()));
  int exact = 0;
  for (const auto& unit : units) {
    if (!std::isfinite(unit.value) || !std::isfinite(unit.sd) || unit.sd < 0.0)
      problems.push_back(
          say("a unit with value {} and standard uncertainty {}: both must be numbers, the "
              "second not negative",
              unit.value, unit.sd));
    exact += unit.sd == 0.0;
  }
  if (exact > 1) problems.push_back(say("{} units are stated without uncertainty; at most one can be", exact));
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

double spread_at_scatter(std::span<const UnitValue> units, double scatter, double from) {
  // Q is convex and falls: Newton's steps from the left never go beyond the root.
  double t = std::max(from, least_spread * square(largest_spread(units)));
  for (int step = 0; step < most_steps_of_spread; ++step) {
    const auto at = mean_at_spread(units, t);
    if (at.q <= scatter) return step == 0 ? from : t;
    const double next = t - (at.q - scatter) / slope_of_scatter(units, t, at.mean);
    if (!(next > t * (1.0 + last_growth))) break;
    t = next;
  }
  return t;
}

UnitSpread spread_of_units(std::span<const UnitValue> units) {
  require_population(units);
  const double freedom = static_cast<double>(units.size()) - 1.0;
  const double t = most_likely_spread(units);
  const auto found = mean_at_spread(units, t);
  UnitSpread out;
  out.mean = found.mean;
  out.mean_sd = std::sqrt(std::max(1.0, found.q / freedom) / found.weight);
  const double half = student_quantile(two_sided_95, freedom) * out.mean_sd;
  out.mean_lower = out.mean - half, out.mean_upper = out.mean + half;
  out.sd = std::sqrt(t);
  out.sd_lower = std::sqrt(spread_at_scatter(units, chi_square_quantile(two_sided_95, freedom)));
  out.sd_upper = std::sqrt(spread_at_scatter(units, chi_square_quantile(below_two_sided_95, freedom)));
  if (t == 0.0) out.sd_upper = std::max(out.sd_upper, std::sqrt(likely_up_to(units)));
  out.scatter = mean_at_spread(units, 0.0).q;
  out.below_stated = out.scatter < chi_square_quantile(below_two_sided_95, freedom);
  return out;
}

}  // namespace tumble
