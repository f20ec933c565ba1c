#include "tumble/methods/dtg_centrifuge/ledger.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/eigen/dense.hpp"
#include "tumble/math/eigen/view.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using Vector = Eigen::Map<const Eigen::VectorXd>;

Vector vector(const std::vector<double>& v) { return {v.data(), at(v.size())}; }

}  // namespace

std::size_t Ledger::add(Group group) {
  groups_.push_back(std::move(group));
  return groups_.size() - 1;
}

void Ledger::add(Parameter parameter, Gradient gradient) {
  parameter.degrees_of_freedom = degrees_of_freedom(gradient);
  parameters_.push_back(std::move(parameter));
  gradients_.push_back(std::move(gradient));
}

double Ledger::variance(const Gradient& gradient) const {
  double sum = 0.0;
  for (const auto& [group, g] : gradient)
    for (const auto& source : groups_[group].sources) sum += vector(g).dot(map(source.covariance) * vector(g));
  return sum;
}

double Ledger::degrees_of_freedom(const Gradient& gradient) const {
  double whole = 0.0, below = 0.0;
  for (const auto& one : gradient) {
    const double v = variance({one});
    whole += v;
    const double nu = groups_[one.first].degrees_of_freedom(one.second);
    if (std::isfinite(nu)) below += v * v / nu;
  }
  return below > 0.0 ? whole * whole / below : std::numeric_limits<double>::infinity();
}

void Ledger::settle(Estimate& estimate) const {
  const std::size_t n = parameters_.size();
  estimate.parameters = parameters_;
  Eigen::MatrixXd total = Eigen::MatrixXd::Zero(at(n), at(n));
  for (std::size_t b = 0; b < groups_.size(); ++b) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(at(n), at(groups_[b].size));
    for (std::size_t i = 0; i < n; ++i)
      for (const auto& [group, g] : gradients_[i])
        if (group == b) jacobian.row(at(i)) += vector(g).transpose();
    if (jacobian.isZero(0.0)) continue;
    for (const auto& source : groups_[b].sources) {
      const Eigen::MatrixXd covariance = jacobian * map(source.covariance) * jacobian.transpose();
      total += covariance;
      auto line = std::ranges::find(estimate.budget, source.source, &Contribution::source);
      if (line == estimate.budget.end()) line = estimate.budget.insert(line, {source.source, std::vector<double>(n)});
      for (std::size_t i = 0; i < n; ++i) line->variance[i] += std::max(0.0, covariance(at(i), at(i)));
    }
  }
  std::erase_if(estimate.budget, [](const Contribution& line) {
    return std::ranges::all_of(line.variance, [](double v) { return v == 0.0; });
  });
  estimate.covariance = plain(0.5 * (total + total.transpose()));
}

}  // namespace tumble::dtg_centrifuge
