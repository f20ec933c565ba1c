#include "tumble/reduce/compensation/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tumble::compensation {
namespace {

/// [1] of the range, and of its ends, that count as inside.
constexpr double beyond_range = 0.02, beyond_values = 1e-6;

constexpr double tolerance = 1e-12;           ///< of the size of u
constexpr double settled_within = 1e-12;      ///< change of an output by a pass over those that need each other
constexpr double greatest_error_slope = 0.5;  ///< dE/du beyond which the model is no model of errors
constexpr int most_steps = 30, most_passes = 30;
/// Of difference quotients: share of the input [1], and the least input [SI].
constexpr double step_share = 1e-4, least_input = 1e-6;

double error_of(const Work& work, const UsedTerm& used, const Values& values) {
  return used.coefficient * regressor_of(used, values) / (used.per_output ? work.scale_factor : 1.0);
}

/// Sum of the curved terms that depend on a slot [SI of u].
double curved_errors(const Work& work, std::size_t slot, const Values& values) {
  double sum = 0.0;
  for (const std::size_t term : work.curved_with[slot]) sum += error_of(work, work.terms[term], values);
  return sum;
}

/// dE/dx [SI of u/SI of x], of curved terms by the difference over a small step to both sides.
double error_slope(const Work& work, std::size_t slot, Values& values) {
  const double linear = work.linear.slopes[slot];
  if (work.curved_with[slot].empty()) return linear;
  const double x = values[slot], step = step_share * std::max(std::abs(x), least_input);
  values[slot] = x + step;
  const double above = curved_errors(work, slot, values);
  values[slot] = x - step;
  const double below = curved_errors(work, slot, values);
  values[slot] = x;
  return linear + (above - below) / (2.0 * step);
}

void solve(Work& work, Values& values) {
  const double y = work.y;
  if (work.model->by_output || work.terms_with[work.shown].empty()) {
    work.u = y - errors_at(work, values);
    if (!work.model->by_output) values[work.shown] = work.u;
    return;
  }
  double u = std::isnan(work.u) ? y : work.u;
  for (int n = 0; n < most_steps; ++n) {
    values[work.shown] = u;
    const double slope = error_slope(work, work.shown, values), g = u + errors_at(work, values) - y;
    if (!(std::abs(slope) < greatest_error_slope)) break;
    if (std::abs(g) <= (1.0 - std::abs(slope)) * tolerance * std::max(std::abs(u), std::abs(y))) {
      work.u = values[work.shown] = u - g / (1.0 + slope);  // this last step costs nothing and gives all digits
      work.slope = slope;
      return;
    }
    u -= g / (1.0 + slope);
  }
  work.u = values[work.shown] = std::nan("");
}

bool outside(double x, double least, double greatest, double noise = 0.0) {
  const double slack =
      beyond_range * (greatest - least) + beyond_values * std::max(std::abs(least), std::abs(greatest)) + noise;
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
  double sum = work.linear.constant;
  for (const auto& [slot, slope] : work.linear.of_slots) sum += slope * values[slot];
  for (const std::size_t term : work.curved) sum += error_of(work, work.terms[term], values);
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

/// d' C e of the derivatives of two outputs by their parameters.
double covariance_of(const Work& one, const Work& other) {
  const Matrix& c = one.estimate->covariance;
  double sum = 0.0;
  for (std::size_t k = 0; k < one.d.size(); ++k) {
    const auto& [i, a] = one.d[k];
    double row = 0.0;
    if (&one == &other) {  // the half below the diagonal counts twice
      for (std::size_t l = 0; l < k; ++l) row += 2.0 * one.d[l].second * c(i, one.d[l].first);
      row += a * c(i, i);
    } else {
      for (const auto& [j, b] : other.d) row += b * c(i, j);
    }
    sum += a * row;
  }
  return sum;
}

std::vector<double> variances_of(const Works& works, Values& values, const Vector3& sd) {
  const std::size_t n = works.size();
  std::vector<double> shared(n * n), share(n), variances(n);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) shared[a * n + b] = shared[b * n + a] = covariance_of(works[a], works[b]);
  for (std::size_t k = 0; k < n; ++k) {
    const Work& work = works[k];
    std::ranges::fill(share, 0.0);
    share[k] = 1.0;
    double staying = work.staying_variance;
    for (const std::size_t other : work.others) {
      if (work.model->by_output) break;
      share[other] = -error_slope(work, works[other].shown, values) / (1.0 + work.slope);
      staying += share[other] * share[other] * works[other].staying_variance;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (sd[axis] > 0.0)
        staying += std::pow(
            sd[axis] * error_slope(work, static_cast<std::size_t>(Input::angular_acceleration_x) + axis, values), 2);
    double sum = 0.0;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        if (share[a] != 0.0 && share[b] != 0.0) sum += share[a] * share[b] * shared[a * n + b];
    variances[k] = (sum < 0.0 ? 0.0 : sum) + staying + work.spread_variance;  // what is no number stays so
  }
  return variances;
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
