#include "tumble/math/regression/optimal_design.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double singular = 1e-13;  ///< smallest eigenvalue, beside the largest, of a determined information

/// Covariance from information; empty where singular. Scaled to a unit diagonal before it is judged.
MatrixXd inverse(const MatrixXd& m) {
  const VectorXd scale = m.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0) || !scale.allFinite()) return {};
  const VectorXd unit = scale.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit.asDiagonal() * m * unit.asDiagonal());
  const VectorXd& values = eigen.eigenvalues();
  if (!(values[0] > singular * values[values.size() - 1])) return {};
  const MatrixXd& v = eigen.eigenvectors();
  return unit.asDiagonal() * (v * values.cwiseInverse().asDiagonal() * v.transpose()) * unit.asDiagonal();
}

/// log det of the rows and columns of interest.
double log_determinant(const MatrixXd& covariance, const std::vector<double>& weights) {
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0.0) kept.push_back(static_cast<Eigen::Index>(i));
  const MatrixXd block = covariance(kept, kept);
  const MatrixXd lower = block.llt().matrixL();
  return 2.0 * lower.diagonal().array().log().sum();
}

}  // namespace

Matrix compressed(const Matrix& rows, double relative) {
  if (rows.rows == 0 || rows.columns == 0) return Matrix(0, rows.columns);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(map(rows));
  const MatrixXd& packed = qr.matrixQR();
  const auto full = std::min(packed.rows(), packed.cols());
  Eigen::Index rank = 0;
  while (rank < full && std::abs(packed(rank, rank)) > relative * std::abs(packed(0, 0))) ++rank;
  const MatrixXd upper = packed.topRows(rank).template triangularView<Eigen::Upper>();
  return plain(upper * qr.colsPermutation().transpose());
}

Matrix information(const DesignPoint& point, double effort) {
  const auto x = map(point.rows);
  if (effort <= 0.0) return Matrix(point.rows.columns, point.rows.columns);
  if (point.disturbance.empty()) return plain(effort * (x.transpose() * x));
  const auto n = map(point.disturbance);
  MatrixXd noise = n * n.transpose();
  noise.diagonal().array() += 1.0 / effort;
  const MatrixXd half = noise.llt().matrixL().solve(x);
  return plain(half.transpose() * half);
}

Matrix information(const DesignProblem& problem, const Design& design) {
  const auto p = problem.parameters;
  MatrixXd sum = MatrixXd::Zero(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(p));
  if (!problem.prior.empty()) sum += map(problem.prior);
  for (const auto& visit : design) {
    const Matrix one = information(problem.points[visit.point], visit.effort);
    sum += map(one);
  }
  return plain(sum);
}

double criterion_of(const DesignProblem& problem, const Design& design) {
  const Matrix sum = information(problem, design);
  const MatrixXd covariance = inverse(map(sum));
  if (covariance.size() == 0) return std::numeric_limits<double>::infinity();
  if (problem.criterion == DesignCriterion::D) return log_determinant(covariance, problem.weights);
  const Eigen::Map<const VectorXd> weights(problem.weights.data(), covariance.rows());
  return weights.dot(covariance.diagonal());
}

std::vector<double> sensitivity(const DesignProblem& problem, const Design& design) {
  const Matrix sum = information(problem, design);
  const MatrixXd covariance = inverse(map(sum));
  std::vector<double> out(problem.points.size(), std::numeric_limits<double>::infinity());
  if (covariance.size() == 0) return out;
  double effort = 0.0;
  for (const auto& visit : design) effort += visit.effort;
  const Eigen::Map<const VectorXd> weights(problem.weights.data(), covariance.rows());
  const bool d = problem.criterion == DesignCriterion::D;
  const MatrixXd middle = d ? covariance : MatrixXd(covariance * weights.asDiagonal() * covariance);
  const double whole = d ? static_cast<double>(problem.parameters) : weights.dot(covariance.diagonal());
  for (std::size_t j = 0; j < out.size(); ++j) {
    const auto x = map(problem.points[j].rows);
    out[j] = effort / whole * (x * middle).cwiseProduct(x).sum();
  }
  return out;
}

}  // namespace tumble
