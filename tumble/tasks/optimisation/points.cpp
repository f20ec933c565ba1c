#include "tumble/tasks/optimisation/points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"

namespace tumble::optimisation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nothing = 1e-9;     ///< information, beside the largest of the point, that is rounding
constexpr double negligible = 1e-3;  ///< variance of a shift, beside that of the white noise of a power-up
constexpr double samples_in_period = 40.0;

double dwell_of(const prediction::Candidate& one, double dwell) { return std::max(dwell, one.least); }

/// Every candidate in a power-up of its own, in which it stands where it begins. The rate is as low as the motions
/// allow: what is known of the noise does not depend on it.
Plan plan_of(const Plan& plan, const std::vector<prediction::Candidate>& all, double settling, double dwell,
             double times) {
  Plan out = plan;
  out.schedule.clear();
  double fastest = 10.0 / dwell;
  for (std::size_t j = 0; j < all.size(); ++j) {
    const auto& one = all[j];
    const int run = static_cast<int>(j) + 1;
    if (!one.approach.empty()) out.schedule.push_back({"approach", 1.0, run, one.approach});
    const double spin_up = one.approach.empty() ? 0.0 : one.spin_up;
    out.schedule.push_back({"work", spin_up + settling + times * dwell_of(one, dwell), run, one.work});
    fastest = std::max(fastest, samples_in_period * one.fastest);
  }
  out.sample_rate = std::min(plan.sample_rate, fastest);
  return out;
}

/// The outputs' information of one segment in one matrix: terms of all outputs, then the errors they share.
void embed(const Matrix& m, std::size_t first_term, const std::vector<std::size_t>& error_at, MatrixXd& into) {
  const std::size_t columns = m.rows - error_at.size();
  const auto place = [&](std::size_t i) {
    return static_cast<Index>(i < columns ? first_term + i : error_at[i - columns]);
  };
  for (std::size_t i = 0; i < m.rows; ++i)
    for (std::size_t j = 0; j < m.columns; ++j) into(place(i), place(j)) += m(i, j);
}

std::vector<MatrixXd> information_of(const Plan& plan, const std::vector<prediction::OutputProblem>& outputs,
                                     DesignSpace& space) {
  std::vector<TermInformation> parts;
  for (auto output : outputs) {
    output.problem.averaging = std::max(1.0 / plan.sample_rate, output.problem.averaging);
    parts.push_back(information_of_terms(plan, output.problem));
  }
  space.terms.clear();
  for (const auto& output : outputs)
    for (const auto& term : output.problem.columns) space.terms.push_back(term.name);
  for (const auto& part : parts)
    for (const auto& error : part.errors)
      if (std::ranges::find(space.errors, error) == space.errors.end()) space.errors.push_back(error);
  const auto size = static_cast<Index>(space.terms.size() + space.errors.size());
  std::vector<MatrixXd> out(plan.schedule.size(), MatrixXd::Zero(size, size));
  std::size_t first = 0;
  for (std::size_t o = 0; o < parts.size(); ++o) {
    std::vector<std::size_t> error_at;
    for (const auto& error : parts[o].errors)
      error_at.push_back(space.terms.size() +
                         static_cast<std::size_t>(std::ranges::find(space.errors, error) - space.errors.begin()));
    for (std::size_t s = 0; s < out.size(); ++s) embed(parts[o].of_segment[s], first, error_at, out[s]);
    first += outputs[o].problem.columns.size();
  }
  return out;
}

/// N with N N' = m, m symmetric; what rounding made negative is nothing.
MatrixXd root(const MatrixXd& m, double least) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (m + m.transpose()));
  Index kept = 0;
  while (kept < m.cols() && eigen.eigenvalues()[m.cols() - 1 - kept] > least) ++kept;
  return eigen.eigenvectors().rightCols(kept) * eigen.eigenvalues().tail(kept).cwiseSqrt().asDiagonal();
}

}  // namespace

// In the space that the point sees (basis U, scaled columns) the information is (P/d + K)^-1: two durations give P, of
// the white noise, and K, of what does not average. With P = L L':  X = L^-1 U',  N N' = L^-1 K L^-T.
DesignPoint point_of(const Matrix& at_once, const Matrix& at_twice, double dwell) {
  const MatrixXd once = map(at_once), twice = map(at_twice);
  VectorXd scale = twice.diagonal().cwiseSqrt();
  for (Index i = 0; i < scale.size(); ++i)
    if (!(scale[i] > 0.0)) scale[i] = 1.0;
  const VectorXd unit = scale.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit.asDiagonal() * twice * unit.asDiagonal());
  const auto p = scale.size();
  const double largest = eigen.eigenvalues()[p - 1];
  Index rank = 0;
  while (rank < p && eigen.eigenvalues()[p - 1 - rank] > nothing * std::max(largest, 1e-300)) ++rank;
  DesignPoint point{Matrix(0, static_cast<std::size_t>(p)), {}};
  if (rank == 0) return point;
  const MatrixXd basis = eigen.eigenvectors().rightCols(rank);
  const MatrixXd first = (basis.transpose() * unit.asDiagonal() * once * unit.asDiagonal() * basis).inverse();
  const MatrixXd second = eigen.eigenvalues().tail(rank).cwiseInverse().asDiagonal();
  MatrixXd white = 2.0 * dwell * (first - second);
  white = (0.5 * (white + white.transpose())).eval();
  const Eigen::LLT<MatrixXd> lower(white);
  if (lower.info() != Eigen::Success) {  // rounding: all of it is white noise
    point.rows = plain(eigen.eigenvalues().tail(rank).cwiseSqrt().asDiagonal() * basis.transpose() *
                       scale.asDiagonal() / std::sqrt(2.0 * dwell));
    return point;
  }
  point.rows = plain(lower.matrixL().solve(MatrixXd(basis.transpose() * scale.asDiagonal())));
  const MatrixXd half = lower.matrixL().solve(second - white / (2.0 * dwell));
  const MatrixXd disturbance = root(lower.matrixL().solve(half.transpose()), nothing / dwell);
  if (disturbance.cols() > 0) point.disturbance = plain(disturbance);
  return point;
}

namespace {

/// Leaves out the errors that shift no output by more than a small part of what a whole power-up of white noise does.
void drop_negligible_errors(DesignSpace& space, std::vector<MatrixXd>& once, std::vector<MatrixXd>& twice, double time,
                            double dwell) {
  std::vector<Index> kept(space.terms.size());
  std::iota(kept.begin(), kept.end(), Index{0});
  std::vector<std::string> errors;
  for (std::size_t e = 0; e < space.errors.size(); ++e) {
    const auto at = static_cast<Index>(space.terms.size() + e);
    double most = 0.0;
    for (const auto& m : twice) most = std::max(most, m(at, at));
    if (most * time / (2.0 * dwell) < negligible) continue;
    kept.push_back(at);
    errors.push_back(space.errors[e]);
  }
  space.errors = std::move(errors);
  for (auto* list : {&once, &twice})
    for (auto& m : *list) m = MatrixXd(m(kept, kept));
}

}  // namespace

DesignSpace design_space(const Plan& plan, const std::vector<prediction::Candidate>& all,
                         const std::vector<prediction::OutputProblem>& outputs, double time, double dwell) {
  DesignSpace space;
  const double settling = outputs.empty() ? 0.0 : outputs.front().problem.settling;
  const auto first = plan_of(plan, all, settling, dwell, 1.0), second = plan_of(plan, all, settling, dwell, 2.0);
  auto once = information_of(first, outputs, space), twice = information_of(second, outputs, space);
  drop_negligible_errors(space, once, twice, time, dwell);
  std::size_t segment = 0;
  for (const auto& one : all) {
    if (!one.approach.empty()) ++segment;
    auto point = point_of(plain(once[segment]), plain(twice[segment]), dwell_of(one, dwell));
    point.setup = one.setup + settling;
    point.least = one.least;
    space.points.push_back(std::move(point));
    ++segment;
  }
  return space;
}

}  // namespace tumble::optimisation
