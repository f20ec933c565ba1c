#include "tumble/methods/dtg_centrifuge/misfit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/methods/dtg_centrifuge/lag.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr double least_variance_of_misfit = 1e-24;  ///< [1] of the square of a residual: below it is rounding

/// Levels less the polynomial, by the quantities of the levels: I - X G [2L x n].
Matrix off_polynomial(const Outcome& outcome, const std::vector<Level>& levels) {
  const Polynomial& p = outcome.polynomial;
  const std::size_t each = p.each();
  Matrix out = levels_with_lag(outcome.levels, p);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const auto regressors = p.row(levels[l]);
    for (std::size_t c = 0; c < p.parts; ++c)
      for (std::size_t k = 0; k < each; ++k)
        for (std::size_t j = 0; j < out.columns; ++j)
          out(l * p.parts + c, j) -= regressors[k] * p.of_levels(c * each + k, j);
  }
  return out;
}

/// Specific force toward the arm's axis that the plan's rig gives at a rate of the arm [m/s^2], and how far its stated
/// errors may move it [1].
struct RigForce {
  double value = 0.0, tolerance = 0.0;
};

/// The Earth's rate turns the arm in addition.
RigForce rig_force(const Settings& rig, double arm_rate) {
  constexpr double least = 1e-3, explained = 6.0;
  const auto number = [&](const char* name) { return rig.has(name) ? rig.number(name) : 0.0; };
  const double square = arm_rate * arm_rate, radius = number("radius") + number("stretch") * square;
  const double sd = std::hypot(number("radius_sd"), number("stretch_sd") * square);
  return {radius * square, least + 2.0 * earth_rate / std::abs(arm_rate) + explained * sd / radius};
}

}  // namespace

LevelMisfit level_misfit(const Outcome& outcome, const std::vector<Level>& levels) {
  const Polynomial& p = outcome.polynomial;
  const auto chosen = std::ranges::find(p.tried, true, &Order::chosen);
  const auto freedom = static_cast<double>(outcome.levels.value.size()) - static_cast<double>(p.value.size());
  LevelMisfit misfit;
  if (chosen == p.tried.end() || !(freedom > 0.0)) return misfit;
  misfit.ratio = chosen->chi_square / freedom;
  misfit.probability = chance_of_ratio(misfit.ratio, freedom, outcome.levels.fit.degrees_of_freedom);
  const Matrix off = off_polynomial(outcome, levels);
  const auto residual = off * outcome.levels.value;
  const Matrix covariance = sandwich(off, outcome.levels.fit.covariance);
  double farthest = 0.0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    double square = 0.0, size = 0.0;
    for (std::size_t i = l * p.parts; i < (l + 1) * p.parts; ++i) {
      square +=
          residual[i] * residual[i] / std::max(covariance(i, i), least_variance_of_misfit * residual[i] * residual[i]);
      size += residual[i] * residual[i];
    }
    if (square <= farthest) continue;
    farthest = square;
    misfit.worst = l;
    misfit.off = std::sqrt(size);
  }
  return misfit;
}

void check_levels(const Outcome& outcome, const std::vector<Level>& levels, Findings& findings) {
  constexpr double rare = 1e-5;
  const LevelMisfit misfit = level_misfit(outcome, levels);
  if (misfit.probability > rare) return;
  findings.push_back({Finding::Severity::error,
                      "levels_off_polynomial",
                      {{"difference", misfit.off, "deg/h/g"},
                       {"times", std::sqrt(misfit.ratio)},
                       {"level", levels[misfit.worst].label}},
                      outcome.output == gyro ? "gyro" : "gyro_y"});
}

void check_forces(const Test& test, const std::vector<Measured>& measured, const Reduction& reduction,
                  Findings& findings) {
  Occurrences off{0, {}, {}};
  double most = 0.0;
  std::vector<FindingValue> values;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Measured& m = measured[i];
    const RigForce rig = rig_force(test.power_ups[m.stretch->power_up].plan->rig, m.arm_rate);
    const double force = std::abs(force_of(reduction.nominal[i], m.arm_rate, 0.0, 0.0));
    const double apart = std::abs(force / rig.value - 1.0);
    if (apart <= rig.tolerance) continue;
    if (off.count++ == 0) off.first = where_of(*m.stretch);
    if (apart <= most) continue;
    most = apart;
    off.worst = where_of(*m.stretch);
    values = {{"force", force, "g"}, {"expected", rig.value, "g"}, {"rate", m.arm_rate, "deg/s"}};
  }
  if (off.count == 0) return;
  findings.push_back({Finding::Severity::error, "force_differs_from_rig", std::move(values), "", off});
}

}  // namespace tumble::dtg_centrifuge
