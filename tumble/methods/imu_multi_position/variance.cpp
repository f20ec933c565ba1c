#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/median.hpp"
#include "tumble/methods/imu_multi_position/fit.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

/// Of the deviance by the logarithm of a variance: 40 times its own variance at most.
constexpr double least_curvature = 0.05;
/// [1] of the last scatter and of the noise, the upper end.
constexpr double search_by_fit = 1e3, search_by_noise = 1e2;
constexpr double beyond_least = 2.0;  ///< in the logarithm above the lower end, from which on a scatter is not zero
constexpr int bits_of_scatter = 8;    ///< to which its logarithm is found
constexpr std::uintmax_t most_evaluations = 30;

/// Variance of an observation [unit of the residual squared]: noise, Earth and scatter.
double variance_of(const Row& row, Part part, const Scatter& scatter) {
  return row.white + row.earth + scatter[static_cast<std::size_t>(part)] * row.unit;
}

/// Adds weight row' row to the equations.
void add(const Row& row, const Group& group, double weight, Chain& chain) {
  const std::size_t first = group.first, n = group.columns;
  const std::span<const double> common(row.common.data(), n);
  for (std::size_t j = 0; j < n; ++j)
    add_scaled(column(chain.common, first + j).subspan(first + j, n - j), weight * common[j], common.subspan(j));
  add_scaled(std::span(chain.right).subspan(first, n), weight * row.residual, common);
  for (std::size_t a = 0; a < group.unknowns(); ++a) {
    const std::size_t k = 2 * group.pair + a;
    const double factor = weight * row.chain[a];
    add_scaled(column(chain.border, k).subspan(first, n), factor, common);
    for (std::size_t b = a; b < group.unknowns(); ++b) chain.band[k][b - a] += factor * row.chain[b];
    chain.chain_right[k] += factor * row.residual;
  }
}

Chain empty_chain(const Fit& fit) {
  Chain chain(fit.unknowns(), 2 * fit.chain.size());
  for (auto& band : chain.band) band[0] = 1e-6;  // for a rest without observations
  return chain;
}

/// Adds the groups in use of the parts whose flag is `flag`. Returned: their sum of log v + r^2/v.
double add_groups(const Fit& fit, const Scatter& scatter, const std::array<bool, 4>& flags, bool flag, Chain& chain) {
  double sum = 0.0;
  for (const Group& group : fit.groups) {
    if (!group.used || flags[static_cast<std::size_t>(group.part)] != flag) continue;
    for (const Row& row : group.rows) {
      const double variance = variance_of(row, group.part, scatter);
      add(row, group, 1.0 / variance, chain);
      sum += std::log(variance) + row.residual * row.residual / variance;
    }
  }
  return sum;
}

/// Median of the noise in the unit of the scatter of a part; 0: no group of it.
double noise_of(const Fit& fit, Part part) {
  std::vector<double> noise;
  for (const Group& group : fit.groups) {
    if (group.part != part || !group.used) continue;
    double sum = 0.0;
    for (const Row& row : group.rows) sum += (row.white + row.earth) / row.unit;
    noise.push_back(sum / static_cast<double>(group.rows.size()));
  }
  return noise.empty() ? 0.0 : median(noise);
}

constexpr double least_ratio = 1e-3, greatest_ratio = 1e12;  ///< scatter to noise, variances

/// -2 log of the restricted likelihood, up to a constant, as a function of the scatter of some parts. The equations of
/// the groups of other parts do not change: they are calculated once.
class Deviance {
 public:
  Deviance(const Fit& of, std::vector<std::size_t> scattering)
      : fit_(of), which_(std::move(scattering)), fixed_(empty_chain(of)) {
    for (const std::size_t i : which_) varies_[i] = true;
    fixed_sum_ = add_groups(fit_, fit_.scatter, varies_, false, fixed_);
  }

  /// Given: logarithms of the scatter of those parts.
  double operator()(const std::vector<double>& logs) const {
    Scatter scatter = fit_.scatter;
    for (std::size_t i = 0; i < which_.size(); ++i) scatter[which_[i]] = std::exp(logs[i]);
    Chain chain = fixed_;
    const double sum = fixed_sum_ + add_groups(fit_, scatter, varies_, true, chain);
    const ChainSolution solution = solve(std::move(chain), false);
    if (!solution.positive_definite) throw_singular();
    return sum + solution.log_determinant - solution.gain;
  }

 private:
  const Fit& fit_;
  std::vector<std::size_t> which_;
  std::array<bool, 4> varies_{};
  Chain fixed_;
  double fixed_sum_ = 0.0;
};

/// Covariance of the logarithms of the scatter of those parts: twice the inverse of the second derivatives.
Matrix covariance_of_scatter(const Fit& fit, const std::vector<std::size_t>& which) {
  const std::size_t n = which.size();
  std::vector<double> logs;
  for (const std::size_t i : which) logs.push_back(std::log(fit.scatter[i]));
  constexpr double h = 0.1;
  const Deviance deviance(fit, which);
  const double middle = deviance(logs);
  const auto shifted = [&](std::size_t i, double a, std::size_t j, double b) {
    auto x = logs;
    x[i] += a, x[j] += b;
    return deviance(x);
  };
  Matrix second(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    second(i, i) = (shifted(i, h, i, 0.0) - 2.0 * middle + shifted(i, -h, i, 0.0)) / (h * h);
    for (std::size_t j = 0; j < i; ++j)
      second(i, j) = second(j, i) =
          (shifted(i, h, j, h) - shifted(i, h, j, -h) - shifted(i, -h, j, h) + shifted(i, -h, j, -h)) / (4.0 * h * h);
  }
  auto eigen = eigen_symmetric(second);
  for (double& value : eigen.values) value = 2.0 / std::max(value, least_curvature);
  return sandwich(eigen.vectors, eigen.values);
}

/// Change of the parameters [p] by a unit of an observation: row of H^-1 J' R^-1.
std::vector<double> gain_of(const Row& row, const Group& group, const ChainSolution& solution, const Fit& fit) {
  std::vector<double> gain(fit.parameters);
  for (std::size_t j = 0; j < group.columns; ++j)
    add_scaled(gain, row.common[j], column(solution.covariance, group.first + j));
  for (std::size_t a = 0; a < group.unknowns(); ++a)
    add_scaled(gain, row.chain[a], column(solution.cross, 2 * group.pair + a));
  return scaled(1.0 / variance_of(row, group.part, fit.scatter), gain);
}

/// The share of each source: H^-1 J' R^-1 R_source R^-1 J H^-1.
void add_shares(const ChainSolution& solution, Fit& fit) {
  for (Matrix& share : fit.shares) share = Matrix(fit.parameters, fit.parameters);
  for (const Group& group : fit.groups) {
    if (!group.used) continue;
    const auto part = static_cast<std::size_t>(group.part);
    for (const Row& row : group.rows) {
      const auto gain = gain_of(row, group, solution, fit);
      if (row.earth > 0.0) add_square(fit.shares[6], row.earth, gain);
      if (group.part == Part::earth) continue;
      add_square(fit.shares[2 * part], row.white, gain);
      add_square(fit.shares[2 * part + 1], fit.scatter[part] * row.unit, gain);
    }
  }
}

void add_degrees_of_freedom(double noise_degrees, Fit& fit) {
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (fit.scatter_significant[i]) which.push_back(i);
  const Matrix of_logs = which.empty() ? Matrix() : covariance_of_scatter(fit, which);
  for (std::size_t p = 0; p < fit.parameters; ++p) {
    std::vector<double> slope;
    for (const std::size_t i : which) slope.push_back(fit.shares[2 * i + 1](p, p));
    double spread = quadratic_form(slope, of_logs);
    for (const std::size_t source : {0, 2, 4})
      spread += 2.0 * std::pow(fit.shares[source](p, p), 2) / std::max(noise_degrees, 1.0);
    fit.degrees_of_freedom.push_back(2.0 * std::pow(fit.covariance(p, p), 2) / std::max(spread, 1e-300));
  }
}

/// Square root of the condition of the matrix of correlations.
double condition_of(const Matrix& covariance) {
  std::vector<double> scale;
  for (const double variance : diagonal_of(covariance)) scale.push_back(1.0 / std::sqrt(variance));
  const auto values = eigenvalues_symmetric(scaled_rows(scale, scaled_columns(covariance, scale)));
  return std::sqrt(values.back() / std::max(values.front(), 1e-300));
}

}  // namespace

Chain normal_equations(const Fit& fit) {
  Chain chain = empty_chain(fit);
  add_groups(fit, fit.scatter, {}, false, chain);
  return chain;
}

double distance_of(const Group& group, const Fit& fit) {
  double sum = 0.0;
  for (const Row& row : group.rows) sum += row.residual * row.residual / variance_of(row, group.part, fit.scatter);
  return std::sqrt(sum);
}

void find_scatter(int rounds, Fit& fit) {
  for (int round = 0; round < rounds; ++round) {
    for (const Part part : parts) {
      const auto i = static_cast<std::size_t>(part);
      const double noise = noise_of(fit, part);
      if (!(noise > 0.0)) continue;
      const double low = std::log(least_ratio * noise);
      const double high =
          std::log(std::clamp(search_by_fit * fit.scatter[i], search_by_noise * noise, greatest_ratio * noise));
      const Deviance deviance(fit, {i});
      const auto value = [&](double x) { return deviance({x}); };
      std::uintmax_t most = most_evaluations;
      const auto best = boost::math::tools::brent_find_minima(value, low, high, bits_of_scatter, most);
      fit.scatter_significant[i] = best.first > low + beyond_least;  // below, it adds nothing
      fit.scatter[i] = fit.scatter_significant[i] ? std::exp(best.first) : least_ratio * noise;
    }
  }
}

void add_uncertainty(double noise_degrees, Fit& fit) {
  const ChainSolution solution = solve(normal_equations(fit), true);
  if (!solution.positive_definite) throw_singular();
  fit.covariance = block(solution.covariance, 0, fit.parameters, 0, fit.parameters);
  add_shares(solution, fit);
  add_degrees_of_freedom(noise_degrees, fit);
  fit.chi_square = -solution.gain;
  for (Group& group : fit.groups) {
    group.distance = distance_of(group, fit);
    if (!group.used || group.part == Part::earth) continue;
    fit.chi_square += group.distance * group.distance;
    fit.observations += group.rows.size();
  }
  fit.condition = condition_of(fit.covariance);
}

void throw_singular() {
  throw Error(Error::Kind::bad_data,
              "the rests do not show all coefficients: lay the unit with each of its axes up and down and with the "
              "edges between them up, in 12 orientations or more, and turn it about all three axes between them");
}

}  // namespace tumble::imu_multi_position
