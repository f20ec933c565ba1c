#include "tumble/tasks/prediction/advice.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/prediction/candidates.hpp"
#include "tumble/tasks/prediction/problem.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::prediction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double condition_limit = 1e6;  ///< of columns of unit length: weaker combinations are not told
constexpr double ridge = 1e-9;
constexpr std::size_t most_additions = 8;
constexpr double coarse = pi / 4.0;

MatrixXd rows_of(const std::vector<Felt>& felt, const std::vector<Term>& terms) {
  MatrixXd rows(static_cast<Index>(felt.size()), static_cast<Index>(terms.size()));
  for (std::size_t i = 0; i < felt.size(); ++i)
    for (std::size_t k = 0; k < terms.size(); ++k)
      rows(static_cast<Index>(i), static_cast<Index>(k)) = terms[k].regressor(felt[i]);
  return rows;
}

/// Number of singular values of columns of unit length; a column of zeros counts nothing.
Index rank_of_rows(MatrixXd rows) {
  for (Index k = 0; k < rows.cols(); ++k)
    if (const double norm = rows.col(k).norm(); norm > 0.0) rows.col(k) /= norm;
  const VectorXd values = Eigen::BDCSVD<MatrixXd>(rows).singularValues();
  Index rank = 0;
  while (rank < values.size() && values[rank] * condition_limit > values[0]) ++rank;
  return rank;
}

/// "x up", "x up 45 deg" for the direction of the specific force at rest.
std::string attitude(const Candidate& candidate) {
  if (candidate.felt.size() != 1) return {};
  const Vector3 f = candidate.felt.front().specific_force;
  const double size = norm(f);
  if (!(size > 0.0)) return {};
  std::string text;
  for (const auto& [name, part] : {std::pair{"x", f.x / size}, {"y", f.y / size}, {"z", f.z / size}}) {
    if (std::abs(part) < 0.02) continue;
    const std::string amount = std::abs(part) > 0.9998 ? "" : fmt::format("{:.2f} ", std::abs(part));
    text += fmt::format("{}{}{}{}", text.empty() ? "" : ", ", amount, name, part > 0.0 ? " up" : " down");
  }
  return " (" + text + ")";
}

/// A schedule that grows by what tells most about its terms.
class Growing {
 public:
  Growing(const Plan& plan, const std::vector<Felt>& felt, const std::vector<Term>& terms)
      : plan_(plan), terms_(terms), rows_(rows_of(felt, terms)) {}

  void add_from(const std::vector<Candidate>& all, std::vector<std::string>& added) {
    std::vector<MatrixXd> offered;
    VectorXd scale = rows_.cwiseAbs().colwise().maxCoeff();
    for (const auto& one : all) {
      offered.push_back(rows_of(one.felt, terms_));
      scale = scale.cwiseMax(offered.back().cwiseAbs().colwise().maxCoeff().transpose());
    }
    for (Index k = 0; k < scale.size(); ++k)
      if (!(scale[k] > 0.0)) scale[k] = 1.0;
    while (rank() < rows_.cols() && added.size() < most_additions) {
      const Index before = rank();
      const auto best = most_telling(offered, scale);
      if (best == offered.size()) return;
      MatrixXd longer(rows_.rows() + offered[best].rows(), rows_.cols());
      longer << rows_, offered[best];
      if (rank_of_rows(longer) <= before) return;
      rows_ = std::move(longer);
      added.push_back(in_words(all[best].work, plan_) + attitude(all[best]));
    }
  }

  Index rank() const { return rank_of_rows(rows_); }

  /// Terms with a part in a combination that neither the rows nor anything offered shows.
  std::vector<std::string> hidden(const std::vector<Candidate>& offered) const {
    const MatrixXd more = rows_of(felt_of(offered), terms_);
    MatrixXd scaled(rows_.rows() + more.rows(), rows_.cols());
    scaled << rows_, more;
    const Index known = rank_of_rows(scaled);
    for (Index k = 0; k < scaled.cols(); ++k)
      if (const double norm = scaled.col(k).norm(); norm > 0.0) scaled.col(k) /= norm;
    const Eigen::BDCSVD<MatrixXd> svd(scaled, Eigen::ComputeFullV);
    std::vector<std::string> names;
    for (Index k = 0; k < scaled.cols(); ++k)
      if (svd.matrixV().row(k).tail(scaled.cols() - known).norm() > 1e-3)
        names.push_back(terms_[static_cast<std::size_t>(k)].name);
    return names;
  }

 private:
  /// tr X (M + ridge)^-1 X', largest where the rows so far say nothing
  std::size_t most_telling(const std::vector<MatrixXd>& offered, const VectorXd& scale) const {
    const MatrixXd own = rows_ * scale.cwiseInverse().asDiagonal();
    MatrixXd information = own.transpose() * own;
    information.diagonal().array() += ridge;
    const MatrixXd covariance = information.llt().solve(MatrixXd::Identity(own.cols(), own.cols()));
    std::size_t best = offered.size();
    double most = 0.0;
    for (std::size_t j = 0; j < offered.size(); ++j) {
      const MatrixXd x = offered[j] * scale.cwiseInverse().asDiagonal();
      const double worth = (x * covariance).cwiseProduct(x).sum() / static_cast<double>(x.rows());
      if (worth > most * (1.0 + 1e-6)) most = worth, best = j;
    }
    return best;
  }

  const Plan& plan_;
  const std::vector<Term>& terms_;
  MatrixXd rows_;
};

}  // namespace

Advice advise(const Plan& plan, const std::vector<Felt>& felt, std::vector<Term> terms,
              const std::vector<Term>& not_excited) {
  Advice out;
  auto range = range_of(plan, coarse);
  range.corners = false;
  const auto near = candidates(plan, range);
  const auto felt_near = felt_of(near);
  for (const auto& term : not_excited)
    if (excited(term, felt_near)) terms.push_back(term);
  if (terms.empty()) return out;
  Growing growing(plan, felt, terms);
  const auto full = static_cast<Index>(terms.size());
  if (growing.rank() == full) return out;
  growing.add_from(near, out.add);
  auto all = near;
  const auto wider = [&] {
    if (growing.rank() == full) return;
    all = candidates(plan, range);
    growing.add_from(all, out.add);
  };
  range.axes.clear();
  for (const auto& axis : find_rig(plan.rig_kind).axes()) range.axes.push_back(axis.name);
  wider();
  if (!range.rates) {
    range.rates = range.sines = true;
    wider();
  }
  if (growing.rank() < full) out.out_of_reach = growing.hidden(all);
  return out;
}

}  // namespace tumble::prediction
