#include "tumble/math/regression/optimal_design/worth.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

// Symbols: M information of a design, C = M^-1, U a square root of a visit's information (U U' = I(d), p x k),
// W the weights of criterion A. A visit added to a design changes the criteria by
//   A:  tr(W C) falls by tr[(I + U'CU)^-1 U'C W C U]        D:  log det C falls by log det(I + U'CU)
// (matrix inversion and determinant lemmas), less, where parameters of no interest are in M, the same for their block.

namespace tumble::optimal_design {
namespace {

constexpr double ridge = 1e-10;  ///< share of what effort spread over all points would tell, added to start from

}  // namespace

Worth::Worth(const DesignProblem& problem) : problem_(problem) {
  scale();
  for (std::size_t i = 0; i < problem.weights.size(); ++i)
    if (!(problem.weights[i] > 0.0)) nuisance_.push_back(static_cast<Index>(i));
}

/// Parameters are scaled so that effort spread over all points would tell as much about each.
void Worth::scale() {
  const auto p = static_cast<Index>(problem_.parameters);
  VectorXd told = VectorXd::Zero(p);
  for (const auto& point : problem_.points) {
    const Eigen::Map<const MatrixXd> x(point.rows.values.data(), static_cast<Index>(point.rows.rows), p);
    told += x.colwise().squaredNorm().transpose();
  }
  told *= problem_.effort / static_cast<double>(std::max<std::size_t>(1, problem_.points.size()));
  prior_ = MatrixXd::Zero(p, p);
  if (!problem_.prior.empty()) prior_ = Eigen::Map<const MatrixXd>(problem_.prior.values.data(), p, p);
  told += prior_.diagonal();
  for (Index i = 0; i < p; ++i)
    if (!(told[i] > 0.0)) told[i] = 1.0;
  const VectorXd unit = told.cwiseSqrt().cwiseInverse();
  prior_ = (unit.asDiagonal() * prior_ * unit.asDiagonal()).eval();
  prior_.diagonal().array() += ridge;
  weights_ = Eigen::Map<const VectorXd>(problem_.weights.data(), p).cwiseProduct(unit.cwiseAbs2());
  for (const auto& point : problem_.points) {
    const auto k = static_cast<Index>(point.rows.rows);
    rows_.push_back(Eigen::Map<const MatrixXd>(point.rows.values.data(), k, p) * unit.asDiagonal());
    const Eigen::Map<const MatrixXd> n(point.disturbance.values.data(), k,
                                       static_cast<Index>(point.disturbance.columns));
    disturbance_.push_back(point.disturbance.empty() ? MatrixXd() : MatrixXd(n * n.transpose()));
  }
}

MatrixXd Worth::root(std::size_t point, long quanta) const {
  const double effort = problem_.quantum * static_cast<double>(quanta);
  const MatrixXd& x = rows_[point];
  if (disturbance_[point].size() == 0) return std::sqrt(effort) * x.transpose();
  if (x.rows() == 1) return x.transpose() / std::sqrt(1.0 / effort + disturbance_[point](0, 0));
  MatrixXd noise = disturbance_[point];
  noise.diagonal().array() += 1.0 / effort;
  return noise.llt().matrixL().solve(x).transpose();
}

State Worth::state(MatrixXd information) const {
  State out;
  const Eigen::LLT<MatrixXd> llt(information);
  if (llt.info() != Eigen::Success) return out;
  out.covariance = llt.solve(MatrixXd::Identity(information.rows(), information.cols()));
  if (problem_.criterion == DesignCriterion::A) {
    out.value = weights_.dot(out.covariance.diagonal());
    return out;
  }
  const MatrixXd lower = llt.matrixL();
  out.value = -2.0 * lower.diagonal().array().log().sum();
  if (!nuisance_.empty()) {
    const Eigen::LLT<MatrixXd> block(MatrixXd(information(nuisance_, nuisance_)));
    const MatrixXd half = block.matrixL();
    out.value += 2.0 * half.diagonal().array().log().sum();
    out.nothing = block.solve(MatrixXd::Identity(half.rows(), half.cols()));
  }
  return out;
}

State Worth::state(const Visits& visits) const {
  MatrixXd information = prior_;
  for (const auto& visit : visits) {
    const MatrixXd u = root(visit.point, visit.quanta);
    information.noalias() += u * u.transpose();
  }
  return state(std::move(information));
}

double Worth::gain(const State& state, const MatrixXd& u) const {
  const MatrixXd g = state.covariance * u;
  if (u.cols() == 1) {
    const double s = 1.0 + u.col(0).dot(g.col(0));
    if (problem_.criterion == DesignCriterion::A) return g.col(0).dot(weights_.cwiseProduct(g.col(0))) / s;
  }
  MatrixXd s = u.transpose() * g;
  s.diagonal().array() += 1.0;
  const Eigen::LLT<MatrixXd> llt(s);
  if (problem_.criterion == DesignCriterion::A) return llt.solve(g.transpose() * weights_.asDiagonal() * g).trace();
  const auto log_det = [](const Eigen::LLT<MatrixXd>& l) {
    return 2.0 * MatrixXd(l.matrixL()).diagonal().array().log().sum();
  };
  double out = log_det(llt);
  if (!nuisance_.empty()) {
    const MatrixXd part = u(nuisance_, Eigen::all);
    MatrixXd t = part.transpose() * state.nothing * part;
    t.diagonal().array() += 1.0;
    out -= log_det(Eigen::LLT<MatrixXd>(t));
  }
  return out;
}

}  // namespace tumble::optimal_design
