#include "tumble/math/regression/least_squares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/normal.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// [1] of the largest, that is named; within which it is 1.
constexpr double named_weight = 0.05, weight_of_one = 0.005;
constexpr double huber = 1.345;  ///< [sd] Huber's k: 95 % efficiency for normal residuals (Holland and Welsch, 1977)
constexpr int rounds_of_weights = 50;
constexpr double last_change_of_weights = 1e-8;

/// The parameters that have a prior.
std::vector<std::size_t> priors_of(const LeastSquaresOptions& options) {
  std::vector<std::size_t> list;
  for (std::size_t k = 0; k < options.prior_sd.size(); ++k)
    if (std::isfinite(options.prior_sd[k])) list.push_back(k);
  return list;
}

double prior_mean(const LeastSquaresOptions& options, std::size_t k) {
  return options.prior_mean.empty() ? 0.0 : options.prior_mean[k];
}

void refuse_unusable(const Matrix& design, const std::vector<double>& observations, const std::vector<double>& weights,
                     std::size_t priors) {
  const auto finite = [](double v) { return std::isfinite(v); };
  if (design.rows != observations.size() || (!weights.empty() && weights.size() != observations.size()))
    throw Error(Error::Kind::internal, "least squares: design, observations and weights differ in length");
  if (!std::ranges::all_of(design.values, finite) || !std::ranges::all_of(observations, finite))
    throw Error(Error::Kind::bad_data, "least squares: the observations or regressors hold values that are not finite");
  if (design.rows + priors < design.columns)
    throw Error(Error::Kind::bad_data,
                say("{} observations cannot determine {} parameters", design.rows, design.columns));
}

/// The weighted design and observations with one more row for each prior.
struct Whitened {
  Matrix design;
  std::vector<double> observations;
};

Whitened whiten(const Matrix& design, std::span<const double> observations, std::span<const double> root_weights,
                const LeastSquaresOptions& options) {
  const auto priors = priors_of(options);
  Whitened w{Matrix(design.rows + priors.size(), design.columns), scaled(root_weights, observations)};
  for (std::size_t j = 0; j < design.columns; ++j)
    for (std::size_t i = 0; i < design.rows; ++i) w.design(i, j) = root_weights[i] * design(i, j);
  for (const std::size_t k : priors) {
    w.design(w.observations.size(), k) = 1.0 / options.prior_sd[k];
    w.observations.push_back(prior_mean(options, k) / options.prior_sd[k]);
  }
  return w;
}

std::string in_words(std::span<const double> direction, const std::vector<std::string>& names) {
  std::vector<std::size_t> order(direction.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](auto a, auto b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  std::string text;
  const double largest = direction[order.front()];
  for (const auto k : order) {
    const double weight = direction[k] / largest;
    if (std::abs(weight) < named_weight) break;
    const std::string name = k < names.size() ? names[k] : fmt::format("parameter {}", k + 1);
    const std::string factor =
        std::abs(std::abs(weight) - 1.0) < weight_of_one ? "" : fmt::format("{:.2g} ", std::abs(weight));
    text += text.empty() ? name : (weight < 0 ? " - " : " + ") + factor + name;
  }
  return text;
}

struct Solution {
  std::vector<double> parameters;
  Matrix inverse_normal;         ///< (X' W X)^-1 on the observable space
  std::vector<double> leverage;  ///< of the first rows
  double condition = 1.0;
  std::size_t rank = 0;
  std::vector<Unobservable> unobservable;
};

/// Householder QR of the column-scaled design, then the SVD of its small triangle for condition and null space.
Solution solve(Whitened w, std::size_t observations, const LeastSquaresOptions& options) {
  const std::size_t p = w.design.columns;
  auto scale = column_norms(w.design);
  std::ranges::replace_if(
      scale, [](double s) { return !(s > 0.0); }, 1.0);  // an empty column is unobservable, see below
  const auto unit = inverses(scale);
  const HouseholderQr qr = householder_qr(scaled_columns(std::move(w.design), unit));
  const Svd triangle = svd(upper_of(qr));
  const auto& s = triangle.values;

  Solution out;
  while (out.rank < p && s[out.rank] * options.condition_limit > s[0]) ++out.rank;
  out.condition = s[p - 1] > 0.0 ? s[0] / s[p - 1] : std::numeric_limits<double>::infinity();
  const auto inverse = inverses(std::span(s).first(out.rank));
  const Matrix half = scaled_rows(unit, scaled_columns(block(triangle.v, 0, p, 0, out.rank), inverse));
  Matrix basis(qr.packed.rows, out.rank);
  set_block(basis, 0, 0, block(triangle.u, 0, p, 0, out.rank));
  basis = q_product(qr, std::move(basis));
  out.parameters = half * transposed_product(basis, w.observations);
  out.inverse_normal = gram(transposed(half));
  out.leverage.resize(observations);
  for (std::size_t k = 0; k < out.rank; ++k)
    for (std::size_t i = 0; i < observations; ++i) out.leverage[i] += square(basis(i, k));
  for (std::size_t k = out.rank; k < p; ++k) {
    const auto direction = column(triangle.v, k);
    out.unobservable.push_back({{direction.begin(), direction.end()}, in_words(direction, options.names)});
  }
  return out;
}

/// Huber's weights of leverage-corrected residuals, k = 1.345, scale from the median absolute deviation.
std::vector<double> huber_weights(std::vector<double> residuals, std::span<const double> leverage) {
  for (std::size_t i = 0; i < residuals.size(); ++i) residuals[i] /= std::sqrt(std::max(1.0 - leverage[i], 1e-12));
  const auto median = [](std::vector<double> v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::ranges::nth_element(v, middle);
    return *middle;
  };
  std::vector<double> deviations = residuals;
  const double centre = median(residuals);
  for (double& v : deviations) v = std::abs(v - centre);
  const double scale = sd_of_median_size * median(std::move(deviations));
  if (!(scale > 0.0)) return std::vector<double>(residuals.size(), 1.0);
  for (double& r : residuals) r = std::min(huber * scale / std::max(std::abs(r), 1e-300), 1.0);
  return residuals;
}

/// Variance factor of Huber's estimate: kappa^2 [sum psi^2/(N-p)]/m^2 with m the share of weights that are one and
/// kappa = 1 + (p/N)(1-m)/m (Huber 1973). To go with (X' W X)^-1 of the weights before robustness.
double huber_variance(std::span<const double> residuals, std::span<const double> robust, double rank) {
  const auto n = static_cast<double>(robust.size());
  const double m = static_cast<double>(std::ranges::count_if(robust, [](double w) { return w >= 1.0; })) / n;
  const double kappa = 1.0 + rank / n * (1.0 - m) / m;
  return square(kappa * norm(scaled(robust, residuals)) / m) / (n - rank);
}

/// A fit and what it was made with, one a row: residuals y - X b, robust weights.
struct Weighed {
  Solution solution;
  std::vector<double> residuals, robust;
};

/// Solved once, or until the robust weights no longer change. Given: root_weights [1/u], one a row.
Weighed weighed(const Matrix& design, const std::vector<double>& observations, std::span<const double> root_weights,
                const LeastSquaresOptions& options) {
  Weighed now{{}, {}, std::vector<double>(design.rows, 1.0)};
  for (int round = 0; round < (options.robust ? rounds_of_weights : 1); ++round) {
    std::vector<double> root(root_weights.begin(), root_weights.end());
    for (std::size_t i = 0; i < root.size(); ++i) root[i] *= std::sqrt(now.robust[i]);
    now.solution = solve(whiten(design, observations, root, options), design.rows, options);
    now.residuals = difference(observations, design * now.solution.parameters);
    if (!options.robust) break;
    auto next = huber_weights(scaled(root_weights, now.residuals), now.solution.leverage);
    double change = 0.0;
    for (std::size_t i = 0; i < next.size(); ++i) change = std::max(change, std::abs(next[i] - now.robust[i]));
    now.robust = std::move(next);
    if (change < last_change_of_weights) break;
  }
  return now;
}

double corrected_akaike(double squares, double rows, double rank) {
  const double k = rank + 1.0, room = rows - k - 1.0;
  if (!(room > 0.0)) return std::numeric_limits<double>::infinity();
  return rows * std::log(squares / rows) + 2.0 * k + 2.0 * k * (k + 1.0) / room;
}

}  // namespace

LeastSquaresFit least_squares(const Matrix& design, const std::vector<double>& observations,
                              const std::vector<double>& weights, const LeastSquaresOptions& options) {
  const auto priors = priors_of(options);
  refuse_unusable(design, observations, weights, priors.size());
  std::vector<double> base(design.rows, 1.0);
  std::ranges::transform(weights, base.begin(), [](double w) { return std::sqrt(w); });
  auto [solution, residuals, robust] = weighed(design, observations, base, options);

  LeastSquaresFit fit;
  const auto whitened = scaled(base, residuals);
  const double squares = dot(scaled(robust, whitened), whitened), rank = static_cast<double>(solution.rank);
  fit.chi_square = squares;
  for (const std::size_t k : priors)
    fit.chi_square += square((solution.parameters[k] - prior_mean(options, k)) / options.prior_sd[k]);
  fit.degrees_of_freedom = static_cast<double>(design.rows + priors.size()) - rank;
  if (!options.known_sigma)
    fit.sigma = fit.degrees_of_freedom > 0 ? std::sqrt(fit.chi_square / fit.degrees_of_freedom)
                                           : std::numeric_limits<double>::infinity();
  if (options.robust) {
    fit.sigma = std::sqrt(huber_variance(whitened, robust, rank));
    solution.inverse_normal = solve(whiten(design, observations, base, options), design.rows, options).inverse_normal;
  }
  fit.parameters = std::move(solution.parameters);
  fit.covariance = square(fit.sigma) * std::move(solution.inverse_normal);
  fit.condition = solution.condition;
  fit.aicc = corrected_akaike(squares, static_cast<double>(design.rows), rank);
  fit.residuals = std::move(residuals);
  fit.leverage = std::move(solution.leverage);
  fit.weights = std::move(robust);
  fit.unobservable = std::move(solution.unobservable);
  return fit;
}

LeastSquaresFit generalised_least_squares(const Matrix& design, const std::vector<double>& observations,
                                          const Matrix& covariance, const LeastSquaresOptions& options) {
  if (covariance.rows != observations.size() || covariance.columns != observations.size())
    throw Error(Error::Kind::internal, "generalised least squares: the covariance must be N x N");
  const Cholesky factor = cholesky(covariance);
  if (!factor.positive)
    throw Error(Error::Kind::bad_data,
                "generalised least squares: the covariance of the observations is not positive definite");
  auto fit = least_squares(solve_lower(factor.lower, design), solve_lower(factor.lower, observations), {}, options);
  fit.residuals = difference(observations, design * fit.parameters);
  return fit;
}

}  // namespace tumble
