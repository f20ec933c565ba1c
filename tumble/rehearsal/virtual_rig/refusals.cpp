#include <cmath>

#include "tumble/rehearsal/virtual_rig/bench.hpp"

namespace tumble::virtual_rig {
namespace {

constexpr double without_end = 1e9;  ///< [s] of a segment of which nobody knows the end
constexpr const char* label = "command";

/// What the rig says against the motion of one axis for this time, where all others stand.
Refusal said_against(const Bench& bench, Schedule trial, const std::string& axis, const Motion& motion, double time) {
  trial.push_back({label, time, 1, {{axis, motion}}});
  const Sentence mine = place_of_segment(label);
  Refusal all;
  for (const Problem& refusal : bench.rig->refusals(trial, bench.plan->rig))
    if (refusal.where.place == mine) all += (all.empty() ? "" : "; ") + refusal.what.text();
  return all;
}

/// How long the rig can keep the motion: it may reach a stop. 0: not at all.
double longest(const Bench& bench, const Schedule& trial, const std::string& axis, const Motion& motion) {
  const auto good = [&](double time) { return said_against(bench, trial, axis, motion, time).empty(); };
  double low = 0.0, high = without_end;
  for (double time = 1e-3; time < without_end; time *= 2.0) {
    if (good(time))
      low = time;
    else if (low > 0.0) {
      high = time;
      break;
    }
  }
  if (low == 0.0) return 0.0;
  while (high - low > 1e-6 * high) {
    const double middle = 0.5 * (low + high);
    (good(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

Motion stop_of(const AxisControl& control, double value) {
  if (control.turns()) return {.kind = Motion::Kind::rate, .value = 0.0};
  if (control.is_air()) return {.kind = Motion::Kind::dwell, .value = value};
  return {.kind = Motion::Kind::hold, .value = control.axis.name == "shake" ? 0.0 : value};
}

Motion Bench::standstill(double time, const std::string& axis) {
  using Kind = Motion::Kind;
  const AxisControl& controller = control(axis);
  const Motion& demand = controller.demand;
  const Kind kind = controller.is_air() ? Kind::dwell : Kind::hold;
  if (axis == "shake") return {.kind = kind, .value = 0.0};
  if (demand.kind == Kind::slew || demand.kind == Kind::ramp)
    return {.kind = kind, .value = demand.to + controller.whole_turns};
  if (demand.kind == Kind::hold || demand.kind == Kind::dwell)
    return {.kind = kind, .value = demand.value + controller.whole_turns};
  return {.kind = kind, .value = drive(time, axis).value};
}

Refusal Bench::refusal_of(double time, const std::string& axis, const Motion& motion, double& trips_after) {
  trips_after = HUGE_VAL;
  if (!rig->refusals) return {};
  Segment standing{"", 1.0, 1, {}};
  for (const auto& [name, controller] : axes)
    if (controller.told) standing.axes.emplace(name, standstill(time, name));
  if (motion.kind == Motion::Kind::rate)  // from where it is
    standing.axes[axis] = {.kind = Motion::Kind::hold, .value = drive(time, axis).value};
  const Refusal refusal = said_against(*this, {standing}, axis, motion, without_end);
  if (refusal.empty() || motion.kind != Motion::Kind::rate) return refusal;
  trips_after = longest(*this, {standing}, axis, motion);
  return trips_after > 0.0 ? Refusal{} : refusal;
}

}  // namespace tumble::virtual_rig
