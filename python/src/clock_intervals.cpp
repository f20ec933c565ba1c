#include "clock_intervals.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/square.hpp"

namespace tumble::python {
namespace {

/// The quantile where there is one: 0 at 0, infinite at 1, else NaN.
double quantile(double probability, double edf) {
  if (!(edf > 0.0 && probability >= 0.0 && probability <= 1.0)) return std::numeric_limits<double>::quiet_NaN();
  if (probability == 0.0) return 0.0;
  if (probability == 1.0) return std::numeric_limits<double>::infinity();
  try {
    return chi_square_quantile(probability, edf);
  } catch (const std::exception&) {  // degrees of freedom beyond what the series can do
    return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

std::pair<double, double> chi_square_limits(double deviation, double edf, double ci) {
  const double below = std::min(std::abs(ci), std::abs(ci - 1.0)) / 2.0;
  const double sum = edf * square(deviation);
  return {std::sqrt(sum / quantile(1.0 - below, edf)), std::sqrt(sum / quantile(below, edf))};
}

double simple_edf(double points, double factor, int alpha) {
  const double n = points, m = factor;
  switch (alpha) {
    case 2:
      return (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m));
    case 1:
      return std::exp(std::sqrt(std::log((n - 1.0) / (2.0 * m)) * std::log((2.0 * m + 1.0) * (n - 1.0) / 4.0)));
    case 0:
      return (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * (4.0 * square(m) / (4.0 * square(m) + 5.0));
    case -1:
      return m < 2.0 ? 2.0 * (n - 2.0) / (2.3 * n - 4.9) : 5.0 * square(n) / (4.0 * m * (n + 3.0 * m));
    case -2:
      return (n - 2.0) / (m * square(n - 3.0)) * (square(n - 1.0) - 3.0 * m * (n - 1.0) + 4.0 * square(m));
    default:
      return n - 1.0;
  }
}

}  // namespace tumble::python
