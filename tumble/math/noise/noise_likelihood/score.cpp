#include "tumble/math/noise/noise_likelihood/score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tumble/math/noise/noise_likelihood/spread.hpp"
#include "tumble/math/stability/allan_fit.hpp"

namespace tumble::noise_likelihood {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double little = 1.2;  ///< variance over that of independent contrasts

/// Third central moment of sum_b u_b z_b. The two ends of quantization are shared by all odd and by all even sines:
/// with Sigma = D + e e' for each and G the weights, 8 trace (G Sigma)^3.
double third_moment(const BandData& data, const TriedTerms& without, const VectorXd& u) {
  const ArrayXd s = without.fit.s.array(), count = data.count.array();
  const ArrayXd ends = variance_of_ends(data.bands, weighted_terms(without)).array().min(s);
  const ArrayXd g = u.array() / count, own = s - ends;
  const double once = (count * g * ends).sum(), twice = (count * g.square() * own * ends).sum(),
               thrice = (count * g.cube() * own.square() * ends).sum();
  return 8.0 * ((count * g.cube() * own.cube()).sum() + 3.0 * thrice + 1.5 * once * twice + 0.25 * std::pow(once, 3));
}

}  // namespace

double chance_by_slope(const BandData& data, const TriedTerms& without, const VectorXd& column) {
  const ScoringFit& fit = without.fit;
  const VectorXd weight = (0.5 * data.count).cwiseSqrt().cwiseQuotient(fit.s);
  VectorXd rest = weight.cwiseProduct(column);
  MatrixXd others = weight.asDiagonal() * linear(data, without).x;
  others = others * others.colwise().norm().cwiseInverse().asDiagonal();
  rest -= others * (others.transpose() * others).ldlt().solve(others.transpose() * rest);
  const VectorXd u = rest.cwiseProduct(weight) / rest.norm();
  const VectorXd z =
      data.z - 2.0 * fit.slope * data.with_ramp + (fit.slope * fit.slope + fit.slope_variance) * data.ramp_square;
  VectorXd each(u.size());
  for (Eigen::Index b = 0; b < u.size(); ++b) each[b] = 2.0 * u[b] / data.bands[static_cast<std::size_t>(b)].count;
  // Independent contrasts give variance 1.
  const double variance = 1.0 + covariance_of_dependence(data.bands, weighted_terms(without), each)(0, 0);
  const double ends = variance_of_ends(data.bands, weighted_terms(without)).cwiseQuotient(fit.s).maxCoeff();
  if (variance < little && ends < little - 1.0) return 0.0;
  const double skew = third_moment(data, without, u) / std::pow(variance, 1.5);
  const double edf = 8.0 / std::max(skew * skew, 1e-6);
  const double off = u.dot(z - fit.s) / std::sqrt(variance * 0.5 * edf);
  return skew > 0.0 ? chi_square_tail(1.0 + off, edf) : 1.0 - chi_square_tail(1.0 - off, edf);
}

}  // namespace tumble::noise_likelihood
