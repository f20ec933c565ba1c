#include "tumble/methods/imu_multi_position/bias_changes.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/square.hpp"

namespace tumble::imu_multi_position {
namespace {

constexpr double rare_change = 1e-4;         ///< [1] below which it is said, of all changes tried
constexpr double suspected_change = 0.05;    ///< [1] below which it is in the uncertainty
constexpr std::size_t fewest_of_change = 9;  ///< rests: bias, three sensitivities and a change leave four
constexpr double noise_explains = 2.0;  ///< [1] of the variance at rest, up to which that noise explains the scatter
/// [1] of the squared bias instability: the variance of the difference of two adjacent means by flicker, 2 (2 ln 2/pi).
constexpr double step_by_flicker = 0.88;

/// The means of one gyro at rest, in units of their noise at rest.
struct GyroMeans {
  Matrix design;                  ///< bias, and sensitivities where these are sought
  std::vector<double> left;       ///< what the fit leaves
  std::vector<double> weight;     ///< [1/unit] root
  std::vector<std::size_t> rest;  ///< in Fit::chain
};

GyroMeans means_of(const Fit& fit, std::size_t gyro) {
  GyroMeans means;
  const bool sensitivity = fit.parameters == with_sensitivity;
  std::vector<const Group*> groups;
  for (const Group& group : fit.groups)
    if (group.part == Part::rate && group.used) groups.push_back(&group);
  means.design = Matrix(groups.size(), sensitivity ? 4 : 1);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Row& row = groups[k]->rows[gyro];
    means.weight.push_back(1.0 / std::sqrt(row.white + row.earth));
    means.left.push_back(means.weight[k] * row.residual);
    means.rest.push_back(groups[k]->pair);
    means.design(k, 0) = means.weight[k];
    for (std::size_t j = 0; sensitivity && j < 3; ++j)
      means.design(k, 1 + j) = means.weight[k] * row.common[gyro_index(gyro, 4 + j) - groups[k]->first];
  }
  return means;
}

/// Tries one column beside the design. Given: variance of the size besides that by the scatter [unit^2].
BiasChange tried(const GyroMeans& means, const std::vector<double>& column, double noise_freedom, double variance) {
  const auto weighted = scaled(means.weight, column);
  const Matrix design = beside(means.design, as_column(weighted));
  const double freedom = static_cast<double>(design.rows) - static_cast<double>(design.columns);
  const Matrix normal = gram(design);
  const std::vector<double> x = solve_symmetric(normal, transposed_product(design, means.left));
  const std::vector<double> predicted = design * x;
  double squares = 0.0;
  for (std::size_t k = 0; k < means.left.size(); ++k) squares += square(means.left[k] - predicted[k]);
  const double scatter = squares / freedom, size = x.back();
  std::vector<double> itself(x.size(), 0.0);
  itself.back() = 1.0;
  const double own = solve_symmetric(normal, itself).back() * std::max(1.0, scatter) + variance;
  BiasChange change{.size = size, .times = std::abs(size) / std::sqrt(own)};
  change.chance =
      chance_of_ratio(square(change.times), 1.0, freedom + (scatter < noise_explains ? noise_freedom : 0.0));
  change.shift.assign(x.begin(), x.end() - 1);
  return change;
}

std::vector<double> step_from(const GyroMeans& means, std::size_t first) {
  std::vector<double> column(means.left.size(), 0.0);
  std::fill(column.begin() + static_cast<std::ptrdiff_t>(first), column.end(), 1.0);
  return column;
}

std::vector<double> drift_over(const GyroMeans& means, const Rests& rests, const Fit& fit) {
  std::vector<double> column;
  for (const std::size_t k : means.rest) column.push_back(rests.all[fit.chain[k]].begin);
  const auto [first, last] = std::ranges::minmax(std::vector<double>(column));
  for (double& time : column) time = (time - first) / (last - first);
  return column;
}

bool one_session(const Rests& rests, const Fit& fit) {
  return std::ranges::all_of(
      fit.chain, [&](std::size_t k) { return rests.all[k].session == rests.all[fit.chain.front()].session; });
}

}  // namespace

std::vector<BiasChange> bias_changes(const Rests& rests, const Fit& fit, double instability) {
  std::vector<BiasChange> changes;
  if (fit.parameters == of_accelerometers || !one_session(rests, fit)) return changes;
  for (std::size_t gyro = 0; gyro < 3; ++gyro) {
    const GyroMeans means = means_of(fit, gyro);
    if (means.left.size() < fewest_of_change) return {};
    const double scale = norm(fit.calibration.gyro.matrix[gyro]);
    const double by_flicker = step_by_flicker * square(instability * scale), noise = rests.noise.degrees_of_freedom;
    BiasChange best = tried(means, drift_over(means, rests, fit), noise, by_flicker);
    best.step = false;
    for (std::size_t k = 1; k < means.left.size(); ++k) {
      BiasChange step = tried(means, step_from(means, k), noise, by_flicker);
      step.from = means.rest[k];
      if (step.times > best.times) best = std::move(step);
    }
    best.gyro = gyro;
    best.chance *= 3.0 * static_cast<double>(means.left.size());
    if (best.chance > suspected_change) continue;
    std::vector<double> shift(fit.parameters, 0.0);
    for (std::size_t j = 0; j < best.shift.size(); ++j) shift[gyro_index(gyro, 3 + j)] = best.shift[j];
    best.shift = std::move(shift);
    changes.push_back(std::move(best));
  }
  return changes;
}

Findings about_changes(const std::vector<BiasChange>& changes, const Fit& fit, const Rests& rests,
                       const std::array<std::string, 3>& names) {
  Findings findings;
  for (const BiasChange& change : changes) {
    if (change.chance > rare_change) continue;
    std::vector<FindingValue> values{{"change", change.size, "deg/h"}, {"times", change.times}};
    if (change.step) values.emplace_back("begin", rests.all[fit.chain[change.from]].begin, "s");
    findings.push_back({Finding::Severity::warning, change.step ? "bias_steps_between_rests" : "bias_drifts_over_rests",
                        std::move(values), names[change.gyro]});
  }
  return findings;
}

}  // namespace tumble::imu_multi_position
