#include "tumble/methods/imu_multi_position/variance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>

#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 24, 1>;
using Small = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

Small variance_of(const Group& group, const Fit& fit) {
  return group.white + group.earth + fit.scatter[static_cast<std::size_t>(group.part)] * group.unit;
}

/// -2 log of the restricted likelihood, up to a constant.
double deviance(const Fit& fit) {
  double sum = 0.0;
  for (const Group& group : fit.groups) {
    if (!group.used) continue;
    const Small v = variance_of(group, fit);
    sum += v.array().log().sum() + group.residual.cwiseAbs2().cwiseQuotient(v).sum();
  }
  const ChainSolution solution = solve(normal_equations(fit), false);
  if (!solution.sound) throw_singular();
  return sum + solution.log_determinant - solution.gain;
}

/// Median of the noise in the unit of the scatter of a part; 0: no group of it.
double noise_of(const Fit& fit, Part part) {
  std::vector<double> all;
  for (const Group& group : fit.groups)
    if (group.part == part && group.used) all.push_back((group.white + group.earth).cwiseQuotient(group.unit).mean());
  if (all.empty()) return 0.0;
  std::nth_element(all.begin(), all.begin() + static_cast<long>(all.size() / 2), all.end());
  return all[all.size() / 2];
}

constexpr double least_ratio = 1e-3, greatest_ratio = 1e12;  ///< scatter to noise, variances

/// -2 log likelihood with the logarithms of the scatter of those parts.
double deviance_at(Fit& fit, const std::vector<std::size_t>& which, const Eigen::VectorXd& logs) {
  const auto kept = fit.scatter;
  for (std::size_t i = 0; i < which.size(); ++i) fit.scatter[which[i]] = std::exp(logs[static_cast<int>(i)]);
  const double value = deviance(fit);
  fit.scatter = kept;
  return value;
}

/// Covariance of the logarithms of the scatter of those parts: twice the inverse of the second derivatives.
Eigen::MatrixXd covariance_of_scatter(Fit& fit, const std::vector<std::size_t>& which) {
  const auto n = static_cast<Eigen::Index>(which.size());
  Eigen::VectorXd at(n);
  for (Eigen::Index i = 0; i < n; ++i) at[i] = std::log(fit.scatter[which[static_cast<std::size_t>(i)]]);
  constexpr double h = 0.1;
  Eigen::MatrixXd second(n, n);
  const double middle = deviance_at(fit, which, at);
  const auto shifted = [&](Eigen::Index i, double a, Eigen::Index j, double b) {
    Eigen::VectorXd x = at;
    x[i] += a, x[j] += b;
    return deviance_at(fit, which, x);
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    second(i, i) = (shifted(i, h, i, 0.0) - 2.0 * middle + shifted(i, -h, i, 0.0)) / (h * h);
    for (Eigen::Index j = 0; j < i; ++j)
      second(i, j) = second(j, i) =
          (shifted(i, h, j, h) - shifted(i, h, j, -h) - shifted(i, -h, j, h) + shifted(i, -h, j, -h)) / (4.0 * h * h);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(second);
  return 2.0 * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.05).cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose();
}

/// The share of each source: H^-1 J' R^-1 R_source R^-1 J H^-1.
void add_shares(const ChainSolution& solution, Fit& fit) {
  const Eigen::Index n = fit.parameters;
  for (auto& share : fit.shares) share.setZero(n, n);
  for (const Group& group : fit.groups) {
    if (!group.used) continue;
    const Small variance = variance_of(group, fit);
    Eigen::MatrixXd gain = group.common * solution.covariance.middleRows(group.first, group.common.cols());
    gain += group.here * solution.with[group.pair];
    if (group.part == Part::turn) gain += group.next * solution.with[group.pair + 1];
    const auto part = static_cast<std::size_t>(group.part);
    for (Eigen::Index i = 0; i < gain.rows(); ++i) {
      const Eigen::VectorXd row = gain.row(i).head(n).transpose() / variance[i];
      if (group.earth[i] > 0.0) fit.shares[6] += group.earth[i] * row * row.transpose();
      if (group.part == Part::earth) continue;
      fit.shares[2 * part] += group.white[i] * row * row.transpose();
      fit.shares[2 * part + 1] += fit.scatter[part] * group.unit[i] * row * row.transpose();
    }
  }
}

void add_degrees_of_freedom(double noise_degrees, Fit& fit) {
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (fit.scatter_seen[i]) which.push_back(i);
  const Eigen::VectorXd variance = fit.covariance.diagonal();
  Eigen::VectorXd spread = Eigen::VectorXd::Zero(variance.size());
  if (!which.empty()) {
    const Eigen::MatrixXd of_logs = covariance_of_scatter(fit, which);
    Eigen::MatrixXd slope(variance.size(), static_cast<Eigen::Index>(which.size()));
    for (std::size_t i = 0; i < which.size(); ++i)
      slope.col(static_cast<Eigen::Index>(i)) = fit.shares[2 * which[i] + 1].diagonal();
    spread = (slope * of_logs).cwiseProduct(slope).rowwise().sum();
  }
  for (const std::size_t source : {0, 2, 4})
    spread += fit.shares[source].diagonal().cwiseAbs2() * 2.0 / std::max(noise_degrees, 1.0);
  fit.degrees_of_freedom = 2.0 * variance.cwiseAbs2().cwiseQuotient(spread.cwiseMax(1e-300));
}

}  // namespace

Chain normal_equations(const Fit& fit) {
  Chain chain(fit.unknowns(), fit.chain.size());
  for (auto& own : chain.own) own = 1e-6 * Eigen::Matrix2d::Identity();  // a rest that nothing speaks of
  for (const Group& group : fit.groups) {
    if (!group.used) continue;
    const Small weight = variance_of(group, fit).cwiseInverse();
    const std::size_t k = group.pair;
    const auto n = group.common.cols();
    auto common = chain.common.block(group.first, group.first, n, n);
    for (Eigen::Index i = 0; i < weight.size(); ++i) {  // row by row: at most three of them
      const Row row = group.common.row(i).transpose();
      const Eigen::Vector2d here = weight[i] * group.here.row(i).transpose();
      common.selfadjointView<Eigen::Lower>().rankUpdate(row, weight[i]);
      chain.right.segment(group.first, n) += weight[i] * group.residual[i] * row;
      for (int c = 0; c < 2; ++c) chain.border[k].col(c).segment(group.first, n) += here[c] * row;
      chain.own[k] += here * group.here.row(i);
      chain.own_right[k] += group.residual[i] * here;
      if (group.part != Part::turn) continue;
      const Eigen::Vector2d next = weight[i] * group.next.row(i).transpose();
      for (int c = 0; c < 2; ++c) chain.border[k + 1].col(c).segment(group.first, n) += next[c] * row;
      chain.next[k] += here * group.next.row(i);
      chain.own[k + 1] += next * group.next.row(i);
      chain.own_right[k + 1] += group.residual[i] * next;
    }
  }
  return chain;
}

double distance_of(const Group& group, const Fit& fit) {
  return std::sqrt(group.residual.cwiseAbs2().cwiseQuotient(variance_of(group, fit)).sum());
}

void find_scatter(int rounds, Fit& fit) {
  for (int round = 0; round < rounds; ++round) {
    for (const Part part : parts) {
      const auto i = static_cast<std::size_t>(part);
      const double noise = noise_of(fit, part);
      if (!(noise > 0.0)) continue;
      const double low = std::log(least_ratio * noise);
      const double high = std::log(std::clamp(1e3 * fit.scatter[i], 1e2 * noise, greatest_ratio * noise));
      const auto value = [&](double x) { return deviance_at(fit, {i}, Eigen::VectorXd::Constant(1, x)); };
      std::uintmax_t most = 30;
      const auto best = boost::math::tools::brent_find_minima(value, low, high, 8, most);
      fit.scatter_seen[i] = best.first > low + 2.0;  // below, it adds nothing
      fit.scatter[i] = fit.scatter_seen[i] ? std::exp(best.first) : least_ratio * noise;
    }
  }
}

void add_uncertainty(double noise_degrees, Fit& fit) {
  const ChainSolution solution = solve(normal_equations(fit), true);
  if (!solution.sound) throw_singular();
  fit.covariance = solution.covariance.topLeftCorner(fit.parameters, fit.parameters);
  add_shares(solution, fit);
  add_degrees_of_freedom(noise_degrees, fit);
  fit.chi_square = -solution.gain;
  for (Group& group : fit.groups) {
    group.distance = distance_of(group, fit);
    if (!group.used || group.part == Part::earth) continue;
    fit.chi_square += group.distance * group.distance;
    fit.observations += static_cast<std::size_t>(group.residual.size());
  }
  const Eigen::VectorXd scale = fit.covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * fit.covariance * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation, Eigen::EigenvaluesOnly);
  fit.condition = std::sqrt(eigen.eigenvalues().maxCoeff() / std::max(eigen.eigenvalues().minCoeff(), 1e-300));
}

void throw_singular() {
  throw Error(Error::Kind::bad_data,
              "the rests do not show all coefficients: lay the unit with each of its axes up and down and with the "
              "edges between them up, 12 ways and more, and turn it about all three axes between them");
}

}  // namespace tumble::imu_multi_position
