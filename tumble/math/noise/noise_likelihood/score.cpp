#include "tumble/math/noise/noise_likelihood/score.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/noise/noise_likelihood/spread.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double little = 1.2;  ///< variance over that of independent contrasts

/// Third central moment of sum_b u_b z_b. The two ends of quantization are shared by all odd and by all even sines:
/// with Sigma = D + e e' for each and G the weights, 8 trace (G Sigma)^3.
double third_moment(const BandData& data, std::span<const double> s, std::span<const double> ends,
                    std::span<const double> u) {
  double own_alone = 0.0, once = 0.0, twice = 0.0, thrice = 0.0;
  for (std::size_t b = 0; b < u.size(); ++b) {
    const double g = u[b] / data.count[b], shared = std::min(ends[b], s[b]), own = s[b] - shared;
    own_alone += data.count[b] * std::pow(g * own, 3);
    once += data.count[b] * g * shared;
    twice += data.count[b] * g * g * own * shared;
    thrice += data.count[b] * g * std::pow(g * own, 2) * shared;
  }
  return 8.0 * (own_alone + 3.0 * thrice + 1.5 * once * twice + 0.25 * std::pow(once, 3));
}

}  // namespace

double chance_by_slope(const BandData& data, const TriedTerms& without, std::span<const double> column,
                       const SearchRange& range) {
  const ScoringFit& fit = without.fit;
  const auto weight = root_weights(data, fit.s);
  Matrix others = scaled_rows(weight, linear(data, without, &range).x);
  others = scaled_columns(others, inverses(column_norms(others)));
  const auto wanted = scaled(weight, column);
  const auto rest = difference(wanted, others * solve_symmetric(gram(others), transposed_product(others, wanted)));
  const auto u = scaled(1.0 / norm(rest), scaled(weight, rest));
  const auto terms = weighted_terms(without);
  const auto ends = variance_of_ends(data.bands, terms);
  std::vector<double> each;
  double sum = 0.0, most = 0.0;
  for (std::size_t b = 0; b < u.size(); ++b) {
    const double z = data.z[b] - 2.0 * fit.slope * data.with_ramp[b] +
                     (fit.slope * fit.slope + fit.slope_variance) * data.ramp_square[b];
    each.push_back(2.0 * u[b] / data.bands[b].count);
    sum += u[b] * (z - fit.s[b]);
    most = std::max(most, ends[b] / fit.s[b]);
  }
  // Independent contrasts give variance 1.
  const double variance = 1.0 + covariance_of_dependence(data.bands, terms, as_column(each))(0, 0);
  if (variance < little && most < little - 1.0) return 0.0;
  const double skew = third_moment(data, fit.s, ends, u) / std::pow(variance, 1.5);
  const double edf = freedom_of_skewness(skew);
  const double off = sum / std::sqrt(variance * 0.5 * edf);
  return skew > 0.0 ? chi_square_tail(1.0 + off, edf) : 1.0 - chi_square_tail(1.0 - off, edf);
}

}  // namespace tumble::noise_likelihood
