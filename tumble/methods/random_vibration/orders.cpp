#include <algorithm>
#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/eigen/dense.hpp"
#include "tumble/methods/random_vibration/statistics.hpp"

namespace tumble::random_vibration {
namespace {

/// The rectification of one unit in each vibration.
struct Rectified {
  std::vector<std::size_t> index;  ///< in Estimate::parameters
  std::vector<double> a_0;         ///< [m/s^2]
};

Rectified rectified(const std::vector<Exposure>& exposures, const vibration::Data& data, std::size_t unit,
                    const Estimate& estimate) {
  Rectified out;
  for (const Exposure& exposure : exposures)
    for (const Measured& measured : exposure.units) {
      if (measured.unit != unit) continue;
      const auto* p = find_parameter(estimate, exposure.prefix + data.units[unit].prefix + "vibration_rectification");
      if (p == nullptr) continue;
      out.index.push_back(static_cast<std::size_t>(p - estimate.parameters.data()));
      out.a_0.push_back(measured.rest.value);
    }
  return out;
}

/// K_2, K_3 = G times the rectifications: least squares with their variances.
Eigen::MatrixXd weights_of(const Rectified& r, const Estimate& estimate) {
  const auto n = static_cast<Eigen::Index>(r.index.size());
  Eigen::MatrixXd design(n, 2), weighted(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    design.row(i) << 1.0, 3.0 * r.a_0[k];
    weighted.row(i) = design.row(i) / estimate.covariance(r.index[k], r.index[k]);
  }
  return (weighted.transpose() * design).ldlt().solve(weighted.transpose());
}

/// Rows of the budget for the linear combinations G of the rectifications.
void append_combinations(const Eigen::MatrixXd& g, const Rectified& r, Estimate& estimate) {
  const std::size_t old = estimate.parameters.size();
  const auto combinations = static_cast<std::size_t>(g.rows());
  for (auto& line : estimate.budget) {
    Matrix longer(old + combinations, line.factor.columns);
    for (std::size_t c = 0; c < longer.columns; ++c) {
      for (std::size_t i = 0; i < old; ++i) longer(i, c) = line.factor(i, c);
      for (std::size_t row = 0; row < combinations; ++row)
        for (std::size_t k = 0; k < r.index.size(); ++k)
          longer(old + row, c) +=
              g(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k)) * line.factor(r.index[k], c);
    }
    line.factor = std::move(longer);
  }
  estimate.covariance = covariance_of(estimate.budget, old + combinations);
}

}  // namespace

void append_orders(const std::vector<Exposure>& exposures, const vibration::Data& data, Estimate& estimate) {
  for (std::size_t unit = 0; unit < data.units.size(); ++unit) {
    const Rectified r = rectified(exposures, data, unit, estimate);
    if (r.index.size() < 2) continue;
    const auto [low, high] = std::ranges::minmax(r.a_0);
    if (high - low < si(1.0, "g")) continue;
    const Eigen::MatrixXd g = weights_of(r, estimate);
    append_combinations(g, r, estimate);
    Parameter second{data.units[unit].prefix + "second_order_coefficient", "K_2", Unit::parse("ug/g^2"), 0.0,
                     "of the rectifications in positions of different a_0"},
        third{data.units[unit].prefix + "third_order_coefficient", "K_3", Unit::parse("ug/g^3"), 0.0,
              "of the rectifications in positions of different a_0"};
    for (std::size_t k = 0; k < r.index.size(); ++k) {
      const Parameter& p = estimate.parameters[r.index[k]];
      second.value += g(0, static_cast<Eigen::Index>(k)) * p.value;
      third.value += g(1, static_cast<Eigen::Index>(k)) * p.value;
      second.degrees_of_freedom = third.degrees_of_freedom = std::min(second.degrees_of_freedom, p.degrees_of_freedom);
    }
    estimate.parameters.push_back(std::move(second));
    estimate.parameters.push_back(std::move(third));
  }
}

}  // namespace tumble::random_vibration
