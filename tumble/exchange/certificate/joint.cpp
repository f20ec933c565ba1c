#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cassert>
#include <cmath>

#include "tumble/exchange/decision.hpp"
#include "tumble/math/normal.hpp"

namespace tumble {
namespace {

/// A limit as the normal deviate of the probability to be beyond it, so that each marginal is that of specific_risk().
double deviate(double probability_beyond) {
  if (probability_beyond <= 0.0) return INFINITY;
  if (probability_beyond >= 1.0) return -INFINITY;
  return -boost::math::quantile(boost::math::normal(), probability_beyond);
}

double phi_inverse(double probability) {
  // Inside of (0, 1): a sample at the very end of its interval would be infinite.
  return boost::math::quantile(boost::math::normal(), std::clamp(probability, 1e-300, 1.0 - 1e-16));
}

/// Lower triangular root of a correlation; a column is zero where a parameter follows from those before it.
Matrix triangular_root(const Matrix& correlation) {
  const std::size_t n = correlation.rows;
  Matrix root(n, n);
  for (std::size_t j = 0; j < n; ++j) {
    double pivot = correlation(j, j);
    for (std::size_t k = 0; k < j; ++k) pivot -= root(j, k) * root(j, k);
    if (pivot < 1e-10) continue;
    root(j, j) = std::sqrt(pivot);
    for (std::size_t i = j + 1; i < n; ++i) {
      double rest = correlation(i, j);
      for (std::size_t k = 0; k < j; ++k) rest -= root(i, k) * root(j, k);
      root(i, j) = rest / root(j, j);
    }
  }
  return root;
}

/// What Genz's transformation integrates over the unit cube: the product of the conditional probabilities.
double product_at(const std::vector<double>& point, const Matrix& root, const std::vector<Tolerance>& limits) {
  const std::size_t n = limits.size();
  std::vector<double> normal(n, 0.0);
  double product = 1.0;
  for (std::size_t i = 0; i < n; ++i) {
    double mean = 0.0;
    for (std::size_t k = 0; k < i; ++k) mean += root(i, k) * normal[k];
    const double width = root(i, i);
    if (width == 0.0) {
      if (!Tolerance{limits[i].lower - 1e-9, limits[i].upper + 1e-9}.holds(mean)) return 0.0;
      continue;
    }
    const double low = normal_below((limits[i].lower - mean) / width),
                 high = normal_below((limits[i].upper - mean) / width);
    product *= high - low;
    if (!(product > 0.0)) return 0.0;
    normal[i] = phi_inverse(low + point[i] * (high - low));
  }
  return product;
}

/// Square roots of primes, by which the lattice of Richtmyer advances.
std::vector<double> lattice_steps(std::size_t count) {
  std::vector<double> steps;
  for (int number = 2; steps.size() < count; ++number) {
    bool prime = true;
    for (int factor = 2; factor * factor <= number; ++factor) prime = prime && number % factor != 0;
    if (prime) steps.push_back(std::sqrt(number));
  }
  return steps;
}

double fraction(double x) { return x - std::floor(x); }

}  // namespace

double joint_conformance(const std::vector<Measured>& measured, const std::vector<Tolerance>& tolerances,
                         const Matrix& correlation) {
  const std::size_t n = measured.size();
  assert(tolerances.size() == n && correlation.rows == n && correlation.columns == n);
  std::vector<Tolerance> limits(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double inf = std::numeric_limits<double>::infinity();
    limits[i] = {-deviate(specific_risk(measured[i], {tolerances[i].lower, inf})),
                 deviate(specific_risk(measured[i], {-inf, tolerances[i].upper}))};
  }
  const Matrix root = triangular_root(correlation);
  const auto steps = lattice_steps(n);
  constexpr int shifts = 8, points = 8192;
  std::vector<double> point(n);
  double sum = 0.0;
  for (int shift = 0; shift < shifts; ++shift)
    for (int k = 1; k <= points; ++k) {
      for (std::size_t i = 0; i < n; ++i) {
        const double at = fraction(k * steps[i] + (shift + 0.5) / shifts * static_cast<double>(i + 1) * 0.6180339887);
        point[i] = std::abs(2.0 * at - 1.0);  // the integrand periodic: the error falls faster
      }
      sum += product_at(point, root, limits);
    }
  return sum / (shifts * points);
}

}  // namespace tumble
