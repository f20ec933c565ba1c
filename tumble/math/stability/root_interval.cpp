#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tumble/math/bisection.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble {
namespace {

constexpr double gamma_to = 1000.0;       ///< degrees of freedom, to which the incomplete gamma function is computed
constexpr double share_widened_by = 1.3;  ///< [sd] of the share
constexpr double least_share_of_root = 1e-3;

/// Wilson and Hilferty (1931): the cube root of chi2/edf is normal with this mean and variance.
struct CubeRoot {
  explicit CubeRoot(double edf) : mean(1.0 - 2.0 / (9.0 * edf)), sd(std::sqrt(2.0 / (9.0 * edf))) {}
  double mean, sd;
};

/// The smallest k for which sqrt(c) +- k sd holds the truth with 95 %: the quantile of the pivot
///   |sqrt(u - 1 + f) - sqrt(f)| / (u sqrt(2/edf)/(2 sqrt(u - 1 + f))),   u = P/E[P], f the share of c in E[P],
/// over the distribution of u where the term comes out positive.
double interval_factor(double edf, double share) {
  const CubeRoot root(edf);
  constexpr int nodes = 801;
  std::vector<std::pair<double, double>> pivots;  // pivot, probability
  double total = 0.0;
  for (int i = 0; i < nodes; ++i) {
    const double z = 4.5 * (2.0 * i / (nodes - 1) - 1.0);
    const double u = std::pow(std::max(0.0, root.mean + root.sd * z), 3), c = u - 1.0 + share;
    if (c <= 0.0) continue;
    const double weight = std::exp(-0.5 * z * z);
    const double error = std::abs(std::sqrt(c) - std::sqrt(share));
    pivots.emplace_back(error * 2.0 * std::sqrt(c) / (u * std::sqrt(2.0 / edf)), weight);
    total += weight;
  }
  std::sort(pivots.begin(), pivots.end());
  double within = 0.0;
  for (const auto& [pivot, weight] : pivots) {
    within += weight;
    if (within >= one_sided_95 * total) return pivot;
  }
  return pivots.back().first;
}

}  // namespace

double chi_square_tail(double ratio, double edf) {
  if (ratio <= 0.0) return 1.0;
  if (edf <= gamma_to) return boost::math::gamma_q(0.5 * edf, 0.5 * edf * ratio);
  const CubeRoot root(edf);  // good to 1e-4 here, where the incomplete gamma function overflows inside
  return normal_above((std::cbrt(ratio) - root.mean) / root.sd);
}

double root_interval_degrees_of_freedom(double edf, double share) {
  constexpr double most = 1e4;
  // The share comes from the same estimate and scatters by (1 - share) sqrt(2/edf); a greater one needs a wider
  // interval, so that a little more than one such sd is added.
  share = std::clamp(share + share_widened_by * (1.0 - share) * std::sqrt(2.0 / edf), least_share_of_root, 1.0);
  const double factor = interval_factor(edf, share);
  if (factor <= student_quantile(two_sided_95, most)) return std::numeric_limits<double>::infinity();
  if (factor >= student_quantile(two_sided_95, 1.0)) return 1.0;
  constexpr int halvings = 40;  // to 1e-11 of the degrees of freedom
  return std::exp(bisected(0.0, std::log(most), halvings, [&](double logarithm) {
                    return student_quantile(two_sided_95, std::exp(logarithm)) > factor;
                  }).middle());
}

}  // namespace tumble
