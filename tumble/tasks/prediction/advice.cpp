#include "tumble/tasks/prediction/advice.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/prediction/candidates.hpp"
#include "tumble/tasks/prediction/problem.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::prediction {
namespace {

constexpr double ridge = 1e-9;
constexpr std::size_t most_additions = 8;
constexpr double coarse = pi / 4.0;

Matrix rows_of(const std::vector<Felt>& felt, const std::vector<Term>& terms) {
  Matrix rows(felt.size(), terms.size());
  for (std::size_t i = 0; i < felt.size(); ++i)
    for (std::size_t k = 0; k < terms.size(); ++k) rows(i, k) = terms[k].regressor(felt[i]);
  return rows;
}

/// Columns of unit length; a column of zeros remains.
Matrix of_unit_length(const Matrix& rows) {
  auto norms = column_norms(rows);
  for (double& norm : norms)
    if (!(norm > 0.0)) norm = 1.0;
  return scaled_columns(rows, inverses(norms));
}

/// Number of singular values of columns of unit length; a column of zeros counts nothing.
std::size_t rank_of_rows(const Matrix& rows) {
  const auto values = singular_values(of_unit_length(rows));
  std::size_t rank = 0;
  while (rank < values.size() && values[rank] * weakest_combination > values[0]) ++rank;
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

/// A schedule that grows by the motions that determine its terms best.
class Growing {
 public:
  Growing(const Plan& plan, const std::vector<Felt>& felt, const std::vector<Term>& terms)
      : plan_(plan), terms_(terms), rows_(rows_of(felt, terms)) {}

  void add_from(const std::vector<Candidate>& all, std::vector<std::string>& added) {
    std::vector<Matrix> offered;
    std::vector<double> scale(terms_.size(), 0.0);
    raise_to(rows_, scale);
    for (const auto& candidate : all) {
      offered.push_back(rows_of(candidate.felt, terms_));
      raise_to(offered.back(), scale);
    }
    for (double& s : scale)
      if (!(s > 0.0)) s = 1.0;
    while (rank() < rows_.columns && added.size() < most_additions) {
      const std::size_t before = rank(), best = best_of(offered, inverses(scale));
      if (best == offered.size()) return;
      Matrix longer = stacked(rows_, offered[best]);
      if (rank_of_rows(longer) <= before) return;
      rows_ = std::move(longer);
      added.push_back(in_words(all[best].work, plan_) + attitude(all[best]));
    }
  }

  std::size_t rank() const { return rank_of_rows(rows_); }

  /// Terms with a part in a combination that neither the rows nor anything offered shows.
  std::vector<std::string> hidden(const std::vector<Candidate>& offered) const {
    const Matrix rows = stacked(rows_, rows_of(felt_of(offered), terms_));
    const std::size_t known = rank_of_rows(rows);
    const Matrix v = svd(of_unit_length(rows)).v;
    std::vector<std::string> names;
    for (std::size_t k = 0; k < rows.columns; ++k)
      if (norm(row(block(v, k, 1, known, rows.columns - known), 0)) > 1e-3) names.push_back(terms_[k].name);
    return names;
  }

 private:
  /// Raises each scale to the greatest magnitude in its column.
  static void raise_to(const Matrix& rows, std::vector<double>& scale) {
    for (std::size_t k = 0; k < rows.columns; ++k)
      for (const double value : column(rows, k)) scale[k] = std::max(scale[k], std::abs(value));
  }

  /// tr X (M + ridge)^-1 X', largest where the rows so far say nothing. Given: inverses of the columns' scales.
  std::size_t best_of(const std::vector<Matrix>& offered, const std::vector<double>& unit) const {
    Matrix information = gram(scaled_columns(rows_, unit));
    for (std::size_t k = 0; k < information.rows; ++k) information(k, k) += ridge;
    const Matrix covariance = solve(cholesky(information), identity(information.rows));
    std::size_t best = offered.size();
    double most = 0.0;
    for (std::size_t j = 0; j < offered.size(); ++j) {
      const Matrix x = scaled_columns(offered[j], unit);
      const double worth = dot((x * covariance).values, x.values) / static_cast<double>(x.rows);
      if (worth > most * (1.0 + 1e-6)) most = worth, best = j;
    }
    return best;
  }

  const Plan& plan_;
  const std::vector<Term>& terms_;
  Matrix rows_;
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
  const std::size_t full = terms.size();
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
