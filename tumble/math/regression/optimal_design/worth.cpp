#include "tumble/math/regression/optimal_design/worth.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

// Symbols: M information of a design, C = M^-1, U a square root of a visit's information (U U' = I(d), p x k),
// W the weights of criterion A. A visit added to a design changes the criteria by
//   A:  tr(W C) falls by tr[(I + U'CU)^-1 U'C W C U]        D:  log det C falls by log det(I + U'CU)
// (matrix inversion and determinant lemmas), less, where parameters of no interest are in M, the same for their block.

namespace tumble::optimal_design {
namespace {

constexpr double ridge = 1e-10;  ///< share of what effort spread over all points would tell, added to start from

void add_to_diagonal(Matrix& a, double value) {
  for (std::size_t i = 0; i < a.rows; ++i) a(i, i) += value;
}

}  // namespace

Worth::Worth(const DesignProblem& problem) : problem_(problem) {
  scale();
  for (std::size_t i = 0; i < problem.weights.size(); ++i)
    if (!(problem.weights[i] > 0.0)) nuisance_.push_back(i);
}

/// Parameters are scaled so that effort spread over all points would tell as much about each.
void Worth::scale() {
  const std::size_t p = problem_.parameters;
  const double each = problem_.effort / static_cast<double>(std::max<std::size_t>(1, problem_.points.size()));
  prior_ = problem_.prior.empty() ? Matrix(p, p) : problem_.prior;
  auto unit = diagonal_of(prior_);
  for (const auto& point : problem_.points)
    for (std::size_t i = 0; i < p; ++i) unit[i] += each * dot(column(point.rows, i), column(point.rows, i));
  for (double& u : unit) u = u > 0.0 ? 1.0 / std::sqrt(u) : 1.0;
  prior_ = scaled_columns(scaled_rows(unit, std::move(prior_)), unit);
  add_to_diagonal(prior_, ridge);
  weights_ = scaled(problem_.weights, scaled(unit, unit));
  for (const auto& point : problem_.points) {
    columns_.push_back(scaled_rows(unit, transposed(point.rows)));
    disturbance_.push_back(point.disturbance.empty() ? Matrix() : gram(transposed(point.disturbance)));
  }
}

Matrix Worth::root(std::size_t point, long quanta) const {
  const double effort = problem_.quantum * static_cast<double>(quanta);
  const Matrix& x = columns_[point];
  if (disturbance_[point].empty()) return std::sqrt(effort) * x;
  if (x.columns == 1) return 1.0 / std::sqrt(1.0 / effort + disturbance_[point](0, 0)) * x;
  Matrix noise = disturbance_[point];
  add_to_diagonal(noise, 1.0 / effort);
  return transposed(solve_lower(cholesky(noise).lower, transposed(x)));
}

State Worth::state(const Matrix& information) const {
  State out;
  const Cholesky factor = cholesky(information);
  if (!factor.positive) return out;
  out.covariance = solve(factor, identity(information.rows));
  if (problem_.criterion == DesignCriterion::A) {
    out.value = dot(weights_, diagonal_of(out.covariance));
    return out;
  }
  out.value = -factor.log_determinant;
  if (!nuisance_.empty()) {
    const Cholesky part = cholesky(chosen_rows(chosen_columns(information, nuisance_), nuisance_));
    out.value += part.log_determinant;
    out.nothing = solve(part, identity(nuisance_.size()));
  }
  return out;
}

State Worth::state(const Visits& visits) const {
  Matrix information = prior_;
  for (const auto& visit : visits) {
    const Matrix u = root(visit.point, visit.quanta);
    for (std::size_t k = 0; k < u.columns; ++k) add_square(information, 1.0, column(u, k));
  }
  return state(information);
}

double Worth::gain(const State& state, const Matrix& u) const {
  const Matrix g = state.covariance * u;
  if (u.columns == 1 && (problem_.criterion == DesignCriterion::A || nuisance_.empty())) {
    double s = 1.0, squares = 0.0;
    for (std::size_t i = 0; i < g.rows; ++i) {
      s += u.values[i] * g.values[i];
      squares += weights_[i] * g.values[i] * g.values[i];
    }
    return problem_.criterion == DesignCriterion::A ? squares / s : std::log(s);
  }
  Matrix s = transposed_product(u, g);
  add_to_diagonal(s, 1.0);
  const Cholesky factor = cholesky(s);
  if (problem_.criterion == DesignCriterion::A) {
    const Matrix half = solve_lower(factor.lower, transposed(g));
    double sum = 0.0;
    for (std::size_t i = 0; i < half.columns; ++i) sum += weights_[i] * dot(column(half, i), column(half, i));
    return sum;
  }
  if (nuisance_.empty()) return factor.log_determinant;
  const Matrix part = chosen_rows(u, nuisance_);
  Matrix t = transposed_product(part, state.nothing * part);
  add_to_diagonal(t, 1.0);
  return factor.log_determinant - cholesky(t).log_determinant;
}

}  // namespace tumble::optimal_design
