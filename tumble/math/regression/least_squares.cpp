#include "tumble/math/regression/least_squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void refuse_unusable(const Matrix& design, const std::vector<double>& observations, const std::vector<double>& weights,
                     std::size_t priors) {
  const auto finite = [](double v) { return std::isfinite(v); };
  if (design.rows != observations.size() || (!weights.empty() && weights.size() != observations.size()))
    throw Error(Error::Kind::internal, "least squares: design, observations and weights differ in length");
  if (!std::ranges::all_of(design.values, finite) || !std::ranges::all_of(observations, finite))
    throw Error(Error::Kind::bad_data, "least squares: the observations or regressors hold values that are not finite");
  if (design.rows + priors < design.columns)
    throw Error(Error::Kind::bad_data,
                fmt::format("{} observations cannot determine {} parameters", design.rows, design.columns));
}

/// The weighted design and observations with one more row for each prior.
struct Whitened {
  MatrixXd design;
  VectorXd observations;
};

Whitened whiten(const Matrix& design, const std::vector<double>& observations, const VectorXd& root_weights,
                const LeastSquaresOptions& options) {
  const auto n = static_cast<Eigen::Index>(design.rows), p = static_cast<Eigen::Index>(design.columns);
  std::vector<Eigen::Index> priors;
  for (std::size_t k = 0; k < options.prior_sd.size(); ++k)
    if (std::isfinite(options.prior_sd[k])) priors.push_back(static_cast<Eigen::Index>(k));
  Whitened w{MatrixXd::Zero(n + static_cast<Eigen::Index>(priors.size()), p), {}};
  w.observations.setZero(w.design.rows());
  w.design.topRows(n) = root_weights.asDiagonal() * map(design);
  w.observations.head(n) = root_weights.cwiseProduct(Eigen::Map<const VectorXd>(observations.data(), n));
  for (std::size_t k = 0; k < priors.size(); ++k) {
    const auto column = static_cast<std::size_t>(priors[k]);
    const auto row = n + static_cast<Eigen::Index>(k);
    w.design(row, priors[k]) = 1.0 / options.prior_sd[column];
    w.observations[row] = (options.prior_mean.empty() ? 0.0 : options.prior_mean[column]) / options.prior_sd[column];
  }
  return w;
}

std::string in_words(const VectorXd& direction, const std::vector<std::string>& names) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(direction.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](auto a, auto b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  std::string text;
  const double largest = direction[order.front()];
  for (const auto k : order) {
    const double weight = direction[k] / largest;
    if (std::abs(weight) < 0.05) break;
    const auto index = static_cast<std::size_t>(k);
    const std::string name = index < names.size() ? names[index] : fmt::format("parameter {}", index + 1);
    const std::string factor = std::abs(std::abs(weight) - 1.0) < 0.005 ? "" : fmt::format("{:.2g} ", std::abs(weight));
    text += text.empty() ? name : (weight < 0 ? " - " : " + ") + factor + name;
  }
  return text;
}

struct Solution {
  VectorXd parameters;
  MatrixXd inverse_normal;  ///< (X' W X)^-1 on the observable space
  VectorXd leverage;        ///< of the first rows
  double condition = 1.0;
  Eigen::Index rank = 0;
  std::vector<Unobservable> unobservable;
};

/// Householder QR of the column-scaled design, then the SVD of its small triangle for condition and null space.
Solution solve(const Whitened& w, Eigen::Index observations, const LeastSquaresOptions& options) {
  const Eigen::Index p = w.design.cols();
  VectorXd scale = w.design.colwise().norm();
  for (auto& s : scale)
    if (!(s > 0.0)) s = 1.0;  // an empty column: unobservable, found below
  const MatrixXd scaled = w.design * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(scaled);
  const MatrixXd q = qr.householderQ() * MatrixXd::Identity(scaled.rows(), p);
  const MatrixXd r = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<MatrixXd> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd& s = svd.singularValues();

  Solution out;
  while (out.rank < p && s[out.rank] * options.condition_limit > s[0]) ++out.rank;
  out.condition = s[p - 1] > 0.0 ? s[0] / s[p - 1] : std::numeric_limits<double>::infinity();
  const auto kept_v = svd.matrixV().leftCols(out.rank);
  const VectorXd inverse = s.head(out.rank).cwiseInverse();
  const MatrixXd half = scale.cwiseInverse().asDiagonal() * kept_v * inverse.asDiagonal();
  const MatrixXd basis = q * svd.matrixU().leftCols(out.rank);
  out.parameters = half * (basis.transpose() * w.observations);
  out.inverse_normal = half * half.transpose();
  out.leverage = basis.topRows(observations).rowwise().squaredNorm();
  for (Eigen::Index k = out.rank; k < p; ++k) {
    const VectorXd v = svd.matrixV().col(k);
    out.unobservable.push_back({{v.data(), v.data() + v.size()}, in_words(v, options.names)});
  }
  return out;
}

/// Huber's weights of leverage-corrected residuals, k = 1.345, scale from the median absolute deviation.
VectorXd huber_weights(const VectorXd& whitened_residuals, const VectorXd& leverage) {
  const VectorXd corrected = whitened_residuals.array() / (1.0 - leverage.array()).max(1e-12).sqrt();
  const auto median = [](std::vector<double> v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::ranges::nth_element(v, middle);
    return *middle;
  };
  std::vector<double> values(corrected.data(), corrected.data() + corrected.size());
  const double centre = median(values);
  for (auto& v : values) v = std::abs(v - centre);
  const double scale = 1.4826 * median(values);
  if (!(scale > 0.0)) return VectorXd::Ones(corrected.size());
  return (1.345 * scale / corrected.array().abs().max(1e-300)).min(1.0);
}

/// Variance factor of Huber's estimate: kappa^2 [sum psi^2/(N-p)]/m^2 with m the share of weights that are one and
/// kappa = 1 + (p/N)(1-m)/m (Huber 1973). To go with (X' W X)^-1 of the
/// weights before robustness.
double huber_variance(const VectorXd& whitened_residuals, const VectorXd& robust, double rank) {
  const double n = static_cast<double>(robust.size());
  const double m = (robust.array() >= 1.0).cast<double>().mean();
  const double kappa = 1.0 + rank / n * (1.0 - m) / m;
  const double psi_square = robust.cwiseProduct(whitened_residuals).squaredNorm();
  return kappa * kappa * psi_square / (n - rank) / (m * m);
}

}  // namespace

LeastSquaresFit least_squares(const Matrix& design, const std::vector<double>& observations,
                              const std::vector<double>& weights, const LeastSquaresOptions& options) {
  const auto priors =
      static_cast<std::size_t>(std::ranges::count_if(options.prior_sd, [](double sd) { return std::isfinite(sd); }));
  refuse_unusable(design, observations, weights, priors);
  const auto n = static_cast<Eigen::Index>(design.rows);
  VectorXd base = VectorXd::Ones(n);
  if (!weights.empty()) base = Eigen::Map<const VectorXd>(weights.data(), n).cwiseSqrt();

  VectorXd robust = VectorXd::Ones(n);
  Solution solution;
  VectorXd residuals;
  const int rounds = options.robust ? 50 : 1;
  for (int round = 0; round < rounds; ++round) {
    solution = solve(whiten(design, observations, base.cwiseProduct(robust.cwiseSqrt()), options), n, options);
    residuals = Eigen::Map<const VectorXd>(observations.data(), n) - map(design) * solution.parameters;
    if (!options.robust) break;
    const VectorXd next = huber_weights(base.cwiseProduct(residuals), solution.leverage);
    const double change = (next - robust).cwiseAbs().maxCoeff();
    robust = next;
    if (change < 1e-8) break;
  }

  LeastSquaresFit fit;
  fit.chi_square = (base.array().square() * robust.array() * residuals.array().square()).sum();
  const double plain_sum = fit.chi_square;
  for (std::size_t k = 0; k < options.prior_sd.size(); ++k) {
    if (!std::isfinite(options.prior_sd[k])) continue;
    const double mean = options.prior_mean.empty() ? 0.0 : options.prior_mean[k];
    fit.chi_square += std::pow((solution.parameters[static_cast<Eigen::Index>(k)] - mean) / options.prior_sd[k], 2);
  }
  fit.degrees_of_freedom = static_cast<double>(design.rows + priors) - static_cast<double>(solution.rank);
  if (!options.known_sigma)
    fit.sigma = fit.degrees_of_freedom > 0 ? std::sqrt(fit.chi_square / fit.degrees_of_freedom)
                                           : std::numeric_limits<double>::infinity();
  fit.parameters.assign(solution.parameters.data(), solution.parameters.data() + solution.parameters.size());
  if (options.robust) {
    fit.sigma = std::sqrt(huber_variance(base.cwiseProduct(residuals), robust, static_cast<double>(solution.rank)));
    solution.inverse_normal = solve(whiten(design, observations, base, options), n, options).inverse_normal;
  }
  fit.covariance = plain(fit.sigma * fit.sigma * solution.inverse_normal);
  fit.condition = solution.condition;
  const double count = static_cast<double>(design.rows), k = static_cast<double>(solution.rank) + 1.0;
  fit.aicc = count - k - 1.0 > 0.0
                 ? count * std::log(plain_sum / count) + 2.0 * k + 2.0 * k * (k + 1.0) / (count - k - 1.0)
                 : std::numeric_limits<double>::infinity();
  fit.residuals.assign(residuals.data(), residuals.data() + n);
  fit.leverage.assign(solution.leverage.data(), solution.leverage.data() + n);
  fit.weights.assign(robust.data(), robust.data() + n);
  fit.unobservable = std::move(solution.unobservable);
  return fit;
}

LeastSquaresFit generalised_least_squares(const Matrix& design, const std::vector<double>& observations,
                                          const Matrix& covariance, const LeastSquaresOptions& options) {
  if (covariance.rows != observations.size() || covariance.columns != observations.size())
    throw Error(Error::Kind::internal, "generalised least squares: the covariance must be N x N");
  const Eigen::LLT<MatrixXd> cholesky(map(covariance));
  if (cholesky.info() != Eigen::Success)
    throw Error(Error::Kind::bad_data,
                "generalised least squares: the covariance of the observations is not positive "
                "definite");
  const auto n = static_cast<Eigen::Index>(observations.size());
  const MatrixXd white_design = cholesky.matrixL().solve(MatrixXd(map(design)));
  const VectorXd white = cholesky.matrixL().solve(VectorXd(Eigen::Map<const VectorXd>(observations.data(), n)));
  auto fit = least_squares(plain(white_design), {white.data(), white.data() + n}, {}, options);
  const Eigen::Map<const VectorXd> b(fit.parameters.data(), static_cast<Eigen::Index>(fit.parameters.size()));
  const VectorXd residuals = Eigen::Map<const VectorXd>(observations.data(), n) - map(design) * b;
  fit.residuals.assign(residuals.data(), residuals.data() + n);
  return fit;
}

}  // namespace tumble
