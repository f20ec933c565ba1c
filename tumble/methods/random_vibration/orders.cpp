#include <algorithm>
#include <cmath>

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

/// Appends linear combinations of parameters, with their covariance and, source by source, their variance; the sources
/// `in_common` act on all of them at once, the others on each by itself.
void append_combinations(const Eigen::MatrixXd& g, const Rectified& r, const std::vector<Common>& common,
                         Estimate& estimate) {
  const std::size_t old = estimate.covariance.rows, n = r.index.size();
  Matrix wider(old + 2, old + 2);
  for (std::size_t i = 0; i < old; ++i)
    for (std::size_t j = 0; j < old; ++j) wider(i, j) = estimate.covariance(i, j);
  const auto gain = [&](std::size_t row, std::size_t k) {
    return g(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k));
  };
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t j = 0; j < old; ++j) {
      for (std::size_t k = 0; k < n; ++k) wider(old + row, j) += gain(row, k) * estimate.covariance(r.index[k], j);
      wider(j, old + row) = wider(old + row, j);
    }
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t other = 0; other < 2; ++other)
      for (std::size_t k = 0; k < n; ++k)
        wider(old + row, old + other) += gain(other, k) * wider(old + row, r.index[k]);
  for (auto& line : estimate.budget)
    for (std::size_t row = 0; row < 2; ++row) {
      double own = 0.0, level = 0.0, of_gain = 0.0;
      std::map<std::size_t, double> scale;
      for (std::size_t k = 0; k < n; ++k) {
        own += gain(row, k) * gain(row, k) * line.variance[r.index[k]];
        level += gain(row, k) * common[r.index[k]].level;
        of_gain += gain(row, k) * common[r.index[k]].gain;
        for (const auto& [unit, slope] : common[r.index[k]].scale) scale[unit] += gain(row, k) * slope;
      }
      double of_scale = 0.0;
      for (const auto& [unit, sum] : scale) of_scale += sum * sum;
      line.variance.push_back(line.source == level_source   ? level * level
                              : line.source == gain_source  ? of_gain * of_gain
                              : line.source == scale_source ? of_scale
                                                            : own);
    }
  estimate.covariance = std::move(wider);
}

}  // namespace

void append_orders(const std::vector<Exposure>& exposures, const vibration::Data& data,
                   const std::vector<Common>& common, Estimate& estimate) {
  for (std::size_t unit = 0; unit < data.units.size(); ++unit) {
    const Rectified r = rectified(exposures, data, unit, estimate);
    if (r.index.size() < 2) continue;
    const auto [low, high] = std::ranges::minmax(r.a_0);
    if (high - low < si(1.0, "g")) continue;
    const Eigen::MatrixXd g = weights_of(r, estimate);
    append_combinations(g, r, common, estimate);
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
