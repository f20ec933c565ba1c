#include "tumble/reduce/coarse_output.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/math/bisection.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

constexpr int most_waves = 300;  ///< of the series: its rest is 1/(2 pi^2 300), 2e-4 of the step squared, without noise

/// Values of the stretches.
struct Values {
  std::set<double> all;   ///< different ones
  double gap = 0.0;       ///< least difference between two of one stretch; 0: none shows two
  double squares = 0.0;   ///< about the means of the stretches
  double freedom = 0.0;   ///< of the squares
  bool resolved = false;  ///< a stretch shows more values than a coarse output does
};

/// Least difference between two values [u].
double least_difference(const std::set<double>& values) {
  double least = INFINITY;
  for (auto v = std::next(values.begin()); v != values.end(); ++v) least = std::min(least, *v - *std::prev(v));
  return least;
}

constexpr std::size_t most_different = 40;  ///< values in a stretch at rest
constexpr std::size_t fewest_different = 4;

void add_different(const std::set<double>& different, Values& values) {
  values.all.insert(different.begin(), different.end());
  if (different.size() < 2) return;
  const double gap = least_difference(different);
  values.gap = values.gap > 0.0 ? std::min(values.gap, gap) : gap;
}

std::set<double> different_in(const Stretch& stretch) {
  std::set<double> different;
  for (const double v : stretch.values)
    if (std::isfinite(v) && different.size() <= most_different) different.insert(v);
  return different;
}

/// Given: a stretch at rest.
void add(const Stretch& stretch, Values& values) {
  const std::set<double> different = different_in(stretch);
  double sum = 0.0, count = 0.0, squares = 0.0;
  for (const double v : stretch.values)
    if (std::isfinite(v)) sum += v, ++count;
  if (count < 2.0) return;
  values.resolved = values.resolved || different.size() > most_different;
  for (const double v : stretch.values)
    if (std::isfinite(v)) squares += square(v - sum / count);
  values.squares += squares;
  values.freedom += count - 1.0;
  add_different(different, values);
}

/// The largest step of which all differences are whole multiples; 0: none.
double common_step(const Values& values) {
  // Within a stretch neighbours are a few steps apart; from stretch to stretch they may be far more.
  constexpr double few_parts = 20.0, most_steps = 2e4, least_steps = 100.0, whole = 1e-5;
  const double first = *values.all.begin(), span = *values.all.rbegin() - first;
  const double gap = values.gap > 0.0 ? values.gap : least_difference(values.all);
  const double most_parts = values.gap > 0.0 ? few_parts : most_steps * gap / span;
  for (double parts = 1.0; parts <= most_parts; ++parts) {
    const double step = gap / parts;
    if (values.gap == 0.0 && !(span > least_steps * step)) continue;
    const auto is_multiple = [&](double v) { return std::abs(std::remainder(v - first, step)) < whole * step; };
    if (std::ranges::all_of(values.all, is_multiple)) return step;
  }
  return 0.0;
}

/// Variance of a mean by rounding, in squares of the step, where the noise is `noise` steps.
double rounding_variance(double noise) {
  double sum = 0.0;
  for (int k = 1; k <= most_waves; ++k) {
    const double root = two_pi * k;
    sum += 2.0 / square(root) * std::exp(-square(root * noise));
  }
  return sum;
}

/// Noise [steps] of samples that scatter by this variance [steps^2] about the mean of their stretch.
double noise_of(double scatter) {
  constexpr int halvings = 60;  // to rounding
  return bisected(0.0, std::sqrt(scatter) + 1.0, halvings,
                  [&](double noise) { return square(noise) + 1.0 / 12.0 - rounding_variance(noise) < scatter; })
      .low;
}

}  // namespace

std::optional<CoarseOutput> coarse_output(const ConductedTest& test) {
  Values values;
  for (const auto& stretch : test.stretches) {
    if (stretch.steady) add(stretch, values);
    if (values.resolved) return {};
  }
  if (values.all.size() < fewest_different)  // at rest one value, or two, of a step that the noise does not cross
    for (const auto& stretch : test.stretches)
      if (!stretch.steady) add_different(different_in(stretch), values);
  if (values.all.size() < fewest_different || !(values.freedom > 0.0)) return {};
  const double step = common_step(values);
  if (!(step > 0.0)) return {};
  const double noise = noise_of(values.squares / values.freedom / square(step));
  return CoarseOutput{step, *values.all.begin(), noise * step, std::sqrt(rounding_variance(noise)) * step};
}

double rounding_sd(double step, double scatter) {
  return step * std::sqrt(rounding_variance(noise_of(square(scatter / step))));
}

}  // namespace tumble
