#include <algorithm>
#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"
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

/// G [2 x n]: K_2, K_3 = G times the rectifications, by least squares with their variances.
Matrix weights_of(const Rectified& r, const Estimate& estimate) {
  Matrix design(r.index.size(), 2);
  std::vector<double> weights;
  for (std::size_t i = 0; i < r.index.size(); ++i) {
    design(i, 0) = 1.0;
    design(i, 1) = 3.0 * r.a_0[i];
    weights.push_back(1.0 / estimate.covariance(r.index[i], r.index[i]));
  }
  return solve_symmetric(gram(design, weights), transposed(scaled_rows(weights, design)));
}

/// Rows of the budget for the linear combinations G of the rectifications.
void append_combinations(const Matrix& g, const Rectified& r, Estimate& estimate) {
  const std::size_t old = estimate.parameters.size();
  for (auto& line : estimate.budget) {
    Matrix longer(old + g.rows, line.factor.columns);
    for (std::size_t c = 0; c < longer.columns; ++c) {
      for (std::size_t i = 0; i < old; ++i) longer(i, c) = line.factor(i, c);
      for (std::size_t j = 0; j < g.rows; ++j)
        for (std::size_t k = 0; k < r.index.size(); ++k) longer(old + j, c) += g(j, k) * line.factor(r.index[k], c);
    }
    line.factor = std::move(longer);
  }
  estimate.covariance = covariance_of(estimate.budget, old + g.rows);
}

}  // namespace

void append_orders(const std::vector<Exposure>& exposures, const vibration::Data& data, Estimate& estimate) {
  for (std::size_t unit = 0; unit < data.units.size(); ++unit) {
    const Rectified r = rectified(exposures, data, unit, estimate);
    if (r.index.size() < 2) continue;
    const auto [low, high] = std::ranges::minmax(r.a_0);
    if (high - low < si(1.0, "g")) continue;
    const Matrix g = weights_of(r, estimate);
    append_combinations(g, r, estimate);
    Parameter second{data.units[unit].prefix + "second_order_coefficient", "K_2", Unit::parse("ug/g^2"), 0.0,
                     "of the rectifications in positions of different a_0"},
        third{data.units[unit].prefix + "third_order_coefficient", "K_3", Unit::parse("ug/g^3"), 0.0,
              "of the rectifications in positions of different a_0"};
    for (std::size_t k = 0; k < r.index.size(); ++k) {
      const Parameter& p = estimate.parameters[r.index[k]];
      second.value += g(0, k) * p.value;
      third.value += g(1, k) * p.value;
      second.degrees_of_freedom = third.degrees_of_freedom = std::min(second.degrees_of_freedom, p.degrees_of_freedom);
    }
    second.channels = third.channels = {data.units[unit].name};
    estimate.parameters.push_back(std::move(second));
    estimate.parameters.push_back(std::move(third));
  }
}

}  // namespace tumble::random_vibration
