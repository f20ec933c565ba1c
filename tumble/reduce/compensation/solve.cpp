#include "tumble/reduce/compensation/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble::compensation {
namespace {

constexpr double tolerance = 1e-12;           ///< of the size of u
constexpr double settled_within = 1e-10;      ///< of outputs together: each is solved to `tolerance` only
constexpr double greatest_error_slope = 0.5;  ///< dE/du beyond which the model is no model of errors
constexpr int most_steps = 30, most_passes = 30;
constexpr double step_share = 1e-4,
                 least_input = 1e-6;  ///< of difference quotients: share of the input [1], and the least input [SI]

double errors_at(const Work& work, Values& values, double u) {
  values[work.shown] = u;
  return compensation::errors_at(work, values);
}

/// dE/dx [SI of u/SI of x] by the difference over a small step to both sides.
double error_slope(const Work& work, std::size_t slot, Values& values) {
  const double x = values[slot], step = step_share * std::max(std::abs(x), least_input);
  values[slot] = x + step;
  const double above = compensation::errors_at(work, values);
  values[slot] = x - step;
  const double below = compensation::errors_at(work, values);
  values[slot] = x;
  return (above - below) / (2.0 * step);
}

void solve(Work& work, Values& values) {
  const double y = work.y;
  if (work.model->by_output) {
    work.u = y - compensation::errors_at(work, values);
    return;
  }
  double u = y;
  for (int n = 0; n < most_steps; ++n) {
    values[work.shown] = u;
    const double slope = error_slope(work, work.shown, values), g = u + errors_at(work, values, u) - y;
    if (!(std::abs(slope) < greatest_error_slope)) break;
    if (std::abs(g) <= (1.0 - std::abs(slope)) * tolerance * std::max(std::abs(u), std::abs(y))) {
      work.u = u, work.slope = slope;
      return;
    }
    u -= g / (1.0 + slope);
  }
  work.u = values[work.shown] = std::nan("");
}

bool outside(double x, double least, double greatest, double noise = 0.0) {
  const double slack = 0.02 * (greatest - least) + 1e-6 * std::max(std::abs(least), std::abs(greatest)) + noise;
  return x < least - slack || x > greatest + slack;
}

bool outside(const Covered& covered, const Values& values) {
  double sum = 0.0;
  for (const auto& [input, weight] : covered.weights) sum += weight * values[static_cast<std::size_t>(input)];
  return outside(sum, covered.least, covered.greatest, covered.noise);
}

/// The terms at the solution: their sizes and u's derivatives. Returned: whether the calibration did not cover them.
bool take_terms(Work& work, const Values& values, const Values& compared) {
  bool far = false;
  const double scale = work.scale_factor;
  double by_output = 0.0;
  work.d.clear();
  for (UsedTerm& used : work.terms) {
    const double x = regressor_of(used, values), part = used.coefficient * x / (used.per_output ? scale : 1.0);
    used.sum += part;
    used.squares += part * part;
    used.largest = std::max(used.largest, std::abs(part));
    if (used.per_output) by_output += part;
    if (used.parameter != SIZE_MAX)
      work.d.emplace_back(used.parameter, -x / (used.per_output ? scale : 1.0) / (1.0 + work.slope));
    far = far || (!work.model->in_region && outside(x, used.least, used.greatest));
  }
  if (work.model->scale) work.d.emplace_back(*work.model->scale, -(work.y - by_output) / scale / (1.0 + work.slope));
  if (work.model->offset) work.d.emplace_back(*work.model->offset, -1.0 / scale / (1.0 + work.slope));
  return far || std::ranges::any_of(work.covered, [&](const Covered& one) { return outside(one, compared); });
}

}  // namespace

std::string name_of(const Slot& slot) {
  const std::string plain = slot.input == Input::channel ? slot.role : name(slot.input);
  return slot.base == SIZE_MAX ? plain : fmt::format("{} after a lag of {:.4g} s", plain, slot.lag);
}

double errors_at(const Work& work, const Values& values) {
  double sum = 0.0;
  for (const auto& used : work.terms)
    sum += used.coefficient * regressor_of(used, values) / (used.per_output ? work.scale_factor : 1.0);
  return sum;
}

void solve_together(Works& works, Values& values) {
  for (int pass = 0; pass < most_passes; ++pass) {
    bool settled = true;
    for (Work& work : works) {
      const double before = work.u;
      solve(work, values);
      const bool blank = std::isnan(work.u) && std::isnan(before);
      settled = settled && (work.others.empty() || work.model->by_output || blank ||
                            std::abs(work.u - before) <= settled_within * std::max(std::abs(work.u), std::abs(work.y)));
    }
    if (settled) return;
  }
  for (Work& work : works)
    if (!work.others.empty()) work.u = std::nan("");
}

double variance_of(const Works& works, const Work& work, Values& values, const Vector3& sd) {
  auto d = work.d;
  double staying = work.staying_variance;
  for (const std::size_t other : work.others) {
    if (work.model->by_output) break;
    const Work& by = works[other];
    const double share = -error_slope(work, by.shown, values) / (1.0 + work.slope);
    for (const auto& [parameter, derivative] : by.d) d.emplace_back(parameter, share * derivative);
    staying += share * share * by.staying_variance;
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (sd[k] > 0.0)
      staying +=
          std::pow(sd[k] * error_slope(work, static_cast<std::size_t>(Input::angular_acceleration_x) + k, values), 2);
  double sum = 0.0;
  for (const auto& [i, a] : d)
    for (const auto& [j, b] : d) sum += a * b * work.estimate->covariance(i, j);
  return (sum < 0.0 ? 0.0 : sum) + staying + work.spread_variance;  // what is no number stays so
}

void take_solution(Work& work, const Values& values, const Values& compared, std::size_t i, bool informed,
                   Channel& channel) {
  const bool measured = !std::isnan(work.y), solved = !std::isnan(work.u);
  work.counts.blank += measured && !informed;
  work.counts.lost += measured && informed && !solved;
  channel.values[i] = work.u;
  work.trust.extrapolated.values[i] = !solved ? std::nan("") : take_terms(work, values, compared) ? 1.0 : 0.0;
  if (!solved) work.d.clear();
  work.counts.samples += solved;
  if (work.trust.extrapolated.values[i] > 0.0 && work.counts.outside++ == 0)
    work.counts.first_outside = work.trust.sd.time(i);
}

void set_cover(const std::vector<Slot>& slots, const Inputs& known, const Works& works, Work& work) {
  for (const Covered& covered : work.model->covered)
    if (std::ranges::all_of(covered.weights, [&](const auto& one) {
          const auto slot = static_cast<std::size_t>(one.first);
          return slot < slots.size() &&
                 (!known.from[slot].empty() || std::ranges::find(works, slot, &Work::shown) != works.end());
        }))
      work.covered.push_back(covered);
}

}  // namespace tumble::compensation
