#include "tumble/math/regression/optimal_design.hpp"

#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"

namespace tumble {
namespace {

constexpr double singular = 1e-13;  ///< smallest eigenvalue, beside the largest, of a determined information

/// Covariance from information; empty where singular. Scaled to a unit diagonal before it is judged.
Matrix covariance_of(const Matrix& information) {
  auto unit = diagonal_of(information);
  for (double& u : unit) {
    if (!(u > 0.0) || !std::isfinite(u)) return {};
    u = 1.0 / std::sqrt(u);
  }
  const auto [values, vectors] = eigen_symmetric(scaled_columns(scaled_rows(unit, information), unit));
  if (!(values.front() > singular * values.back())) return {};
  return sandwich(scaled_rows(unit, vectors), inverses(values));
}

/// ln det of the rows and columns of interest.
double log_determinant(const Matrix& covariance, const std::vector<double>& weights) {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0.0) list.push_back(i);
  return cholesky(chosen_rows(chosen_columns(covariance, list), list)).log_determinant;
}

}  // namespace

Matrix information(const DesignPoint& point, double effort) {
  if (effort <= 0.0) return Matrix(point.rows.columns, point.rows.columns);
  if (point.disturbance.empty()) return effort * gram(point.rows);
  Matrix noise = gram(transposed(point.disturbance));
  for (std::size_t i = 0; i < noise.rows; ++i) noise(i, i) += 1.0 / effort;
  return gram(solve_lower(cholesky(noise).lower, point.rows));
}

Matrix information(const DesignProblem& problem, const Design& design) {
  Matrix sum = problem.prior.empty() ? Matrix(problem.parameters, problem.parameters) : problem.prior;
  for (const auto& visit : design) sum += information(problem.points[visit.point], visit.effort);
  return sum;
}

double criterion_of(const DesignProblem& problem, const Design& design) {
  const Matrix covariance = covariance_of(information(problem, design));
  if (covariance.empty()) return std::numeric_limits<double>::infinity();
  if (problem.criterion == DesignCriterion::D) return log_determinant(covariance, problem.weights);
  return dot(problem.weights, diagonal_of(covariance));
}

std::vector<double> sensitivity(const DesignProblem& problem, const Design& design) {
  const Matrix covariance = covariance_of(information(problem, design));
  std::vector<double> out(problem.points.size(), std::numeric_limits<double>::infinity());
  if (covariance.empty()) return out;
  double effort = 0.0;
  for (const auto& visit : design) effort += visit.effort;
  const bool d = problem.criterion == DesignCriterion::D;
  const Matrix middle = d ? covariance : sandwich(covariance, problem.weights);
  const double sum = d ? static_cast<double>(problem.parameters) : dot(problem.weights, diagonal_of(covariance));
  for (std::size_t j = 0; j < out.size(); ++j) {
    const Matrix& x = problem.points[j].rows;
    out[j] = effort / sum * dot((x * middle).values, x.values);
  }
  return out;
}

}  // namespace tumble
