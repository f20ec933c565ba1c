#include "tumble/methods/dtg_centrifuge/ledger.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/answer.hpp"

namespace tumble::dtg_centrifuge {
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
    for (const auto& source : groups_[group].sources) sum += quadratic_form(g, source.covariance);
  return sum;
}

double Ledger::degrees_of_freedom(const Gradient& gradient) const {
  double sum = 0.0, below = 0.0;
  for (const auto& [group, g] : gradient) {
    const double v = variance({{group, g}}), nu = groups_[group].degrees_of_freedom(g);
    sum += v;
    if (std::isfinite(nu)) below += v * v / nu;
  }
  return below > 0.0 ? sum * sum / below : std::numeric_limits<double>::infinity();
}

void Ledger::settle(Estimate& estimate) const {
  const std::size_t n = parameters_.size();
  estimate.parameters = parameters_;
  std::vector<ErrorLine> lines;
  for (std::size_t b = 0; b < groups_.size(); ++b) {
    Matrix jacobian(n, groups_[b].size);
    for (std::size_t i = 0; i < n; ++i)
      for (const auto& [group, g] : gradients_[i])
        for (std::size_t k = 0; k < g.size() && group == b; ++k) jacobian(i, k) += g[k];
    if (std::ranges::all_of(jacobian.values, [](double v) { return v == 0.0; })) continue;
    for (auto& line : carried(jacobian, lines_of(groups_[b].sources))) lines.push_back(std::move(line));
  }
  tumble::settle(estimate, lines);
}

}  // namespace tumble::dtg_centrifuge
