#include "tumble/math/population/outliers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "tumble/math/bisection.hpp"
#include "tumble/math/median.hpp"
#include "tumble/math/population/expected_spread.hpp"
#include "tumble/math/random.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr int most_passes_of_outliers = 8;  ///< where units go in and out, the last decides

/// t with median (y - mean)^2/(t + u^2) = 0.4549, the median of chi-square with one degree of freedom: half of the
/// units may be of another population.
double robust_spread(std::span<const UnitValue> units, double mean) {
  constexpr double median_of_chi_square = 0.454936;
  const auto middle = [&](double t) {
    std::vector<double> ratios;
    for (const auto& unit : units) ratios.push_back(square(unit.value - mean) / std::max(t + square(unit.sd), 1e-300));
    return median(std::move(ratios));
  };
  if (middle(0.0) <= median_of_chi_square) return 0.0;
  double high = 0.0;
  for (const auto& unit : units) high = std::max(high, square(unit.value - mean));
  high *= 4.0;
  constexpr int halvings = 100;  // to rounding, for a spread of 1e-15 of the largest distance too
  return bisected(0.0, high, halvings, [&](double t) { return middle(t) > median_of_chi_square; }).high;
}

double two_sided(double z, double freedom) {
  return 2.0 * cdf(complement(boost::math::students_t(freedom), std::abs(z)));
}

/// Benjamini and Hochberg: all up to the largest k with p_(k) <= k share/n.
std::vector<bool> marked(const std::vector<double>& p, double share) {
  std::vector<double> sorted(p);
  std::ranges::sort(sorted);
  double limit = -1.0;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (sorted[k] <= share * static_cast<double>(k + 1) / static_cast<double>(sorted.size())) limit = sorted[k];
  std::vector<bool> out;
  for (const double value : p) out.push_back(value <= limit);
  return out;
}

std::vector<UnitValue> without(std::span<const UnitValue> units, const std::vector<bool>& outlier) {
  std::vector<UnitValue> kept;
  for (std::size_t i = 0; i < units.size(); ++i)
    if (!outlier[i]) kept.push_back(units[i]);
  return kept;
}

/// Distance of each unit from the mean of the kept ones without it.
void judge(std::span<const UnitValue> units, double t, double mean, double weight, OutlierUnits& out) {
  const double freedom = static_cast<double>(units.size()) - 2.0;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const double variance = t + square(units[i].sd), lever = out.outlier[i] ? 0.0 : 1.0 / (variance * weight);
    const double away = units[i].value - mean;
    out.z[i] = out.outlier[i] ? away / std::sqrt(variance + 1.0 / weight)
               : lever < 1.0  ? away / (1.0 - lever) / std::sqrt(variance / (1.0 - lever))
                              : 0.0;
    out.p[i] = two_sided(out.z[i], freedom);
  }
}

/// More than a quarter of the units are a part of the population: the middle of a few units is narrow by chance.
void keep_all(std::span<const UnitValue> units, OutlierUnits& out) {
  out.outlier.assign(units.size(), false);
  const double t = most_likely_spread(units);
  const auto at = mean_at_spread(units, t);
  judge(units, t, at.mean, at.weight, out);
}

struct Sides {
  double before = 0.0, after = 0.0, weight_before = 0.0, weight_after = 0.0;

  double step() const { return after / weight_after - before / weight_before; }
  double sd() const { return std::sqrt(1.0 / weight_before + 1.0 / weight_after); }
};

constexpr std::size_t least_side = 3;

/// Calls visit(k, sides) for every place k of a change in this order of units.
template <class Visit>
void at_each_place(std::span<const UnitValue> units, std::span<const std::size_t> order, double t, const Visit& visit) {
  Sides sides;
  for (const auto& unit : units) {
    const double weight = 1.0 / (t + square(unit.sd));
    sides.after += weight * unit.value, sides.weight_after += weight;
  }
  for (std::size_t k = 1; k + least_side <= units.size(); ++k) {
    const auto& unit = units[order[k - 1]];
    const double weight = 1.0 / (t + square(unit.sd));
    sides.after -= weight * unit.value, sides.weight_after -= weight;
    sides.before += weight * unit.value, sides.weight_before += weight;
    if (k >= least_side) visit(k, sides);
  }
}

double largest_z(std::span<const UnitValue> units, std::span<const std::size_t> order, double t) {
  double most = 0.0;
  at_each_place(units, order, t,
                [&](std::size_t, const Sides& s) { most = std::max(most, std::abs(s.step()) / s.sd()); });
  return most;
}

/// Share of the random orders whose largest z is as large.
double p_of_permutations(std::span<const UnitValue> units, std::vector<std::size_t> order, double t, double z,
                         std::uint64_t seed) {
  constexpr int permutations = 999;
  const RandomStream random(seed);
  int as_large = 1;
  for (int n = 0; n < permutations; ++n) {
    const auto draw = random.split(static_cast<std::uint64_t>(n));
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(draw.uniform(i) * static_cast<double>(i))]);
    as_large += largest_z(units, order, t) >= z;
  }
  return as_large / (permutations + 1.0);
}

}  // namespace

OutlierUnits outlier_units(std::span<const UnitValue> units, double false_discovery) {
  if (units.size() < fewest_units_of_population)
    throw Error(Error::Kind::bad_data, say("{} units: at least 5 units are needed to detect outliers", units.size()));
  static_cast<void>(spread_of_units(units));  // its problems
  OutlierUnits out;
  out.z.resize(units.size());
  out.p.resize(units.size());
  out.outlier.assign(units.size(), false);
  std::vector<double> values;
  for (const auto& unit : units) values.push_back(unit.value);
  double mean = median(std::move(values)), t = robust_spread(units, mean);
  const double weight = mean_at_spread(units, t).weight;
  for (std::size_t i = 0; i < units.size(); ++i) {
    out.z[i] = (units[i].value - mean) / std::sqrt(t + square(units[i].sd) + 1.0 / weight);
    out.p[i] = two_sided(out.z[i], static_cast<double>(units.size()) - 2.0);
  }
  for (int pass = 0; pass < most_passes_of_outliers; ++pass) {
    const auto before = out.outlier;
    out.outlier = marked(out.p, false_discovery);
    const auto kept = without(units, out.outlier);
    if (kept.size() < 3 || (pass > 0 && out.outlier == before)) break;
    t = most_likely_spread(kept);
    const auto at = mean_at_spread(kept, t);
    judge(units, t, at.mean, at.weight, out);
  }
  if (4 * static_cast<std::size_t>(std::ranges::count(out.outlier, true)) > units.size()) keep_all(units, out);
  const auto kept = without(units, out.outlier);
  out.kept = spread_of_units(kept.size() < 3 ? units : std::span<const UnitValue>(kept));
  return out;
}

BatchChange batch_change(std::span<const UnitValue> units, double t, std::uint64_t seed) {
  if (units.size() < 2 * least_side)
    throw Error(Error::Kind::bad_data, say("{} units: at least 6 units are needed to detect a change", units.size()));
  std::vector<std::size_t> order(units.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  BatchChange out;
  std::vector<std::pair<std::size_t, double>> places;
  at_each_place(units, order, t, [&](std::size_t k, const Sides& sides) {
    const double z = std::abs(sides.step()) / sides.sd();
    places.emplace_back(k, z);
    if (z > out.z) out.z = z, out.after = k, out.step = sides.step(), out.step_sd = sides.sd();
  });
  constexpr double drop = 8.0;  // of z^2, by simulation
  out.earliest = units.size();
  for (const auto& [k, z] : places)
    if (z * z >= out.z * out.z - drop) out.earliest = std::min(out.earliest, k), out.latest = std::max(out.latest, k);
  out.p = p_of_permutations(units, order, t, out.z, seed);
  return out;
}

}  // namespace tumble
