#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/rehearsal/virtual_rig/bench.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::virtual_rig {
namespace {

using Kind = Motion::Kind;

constexpr double swing_frequency = 0.5;  ///< [Hz] of an axis that does not settle
constexpr double swing_of_rate = 1.0;    ///< [s] between changes of a rate that does not settle
constexpr double swing_of_air = 120.0;   ///< [s] the same of a temperature
constexpr double first_drift = 1.0;      ///< [s] after which a drifting rate is first set anew
constexpr double drift_growth = 0.02;    ///< of the time since then: so that long tests do not become long schedules

bool goes_somewhere(const Motion& motion) { return motion.kind == Kind::hold || motion.kind == Kind::slew; }

double& target_of(Motion& motion) {
  return motion.kind == Kind::slew || motion.kind == Kind::ramp ? motion.to : motion.value;
}

/// The fastest change of the air [K/s].
double ramp_limit(const Settings& options) {
  return options.number(options.has("oven_ramp_limit") ? "oven_ramp_limit" : "ramp_limit");
}

/// Whether a run may begin with this motion in place of the standstill that it begins with: a rig begins a run where
/// its first segment wants it.
bool begins_at(const Motion* standing, const Motion& motion) {
  const double value = standing ? standing->value : 0.0;
  if (motion.kind == Kind::hold || motion.kind == Kind::dwell) return standing && motion.value == value;
  return motion.kind != Kind::ramp && value == 0.0;
}

}  // namespace

/// What the drive makes of a command, as its troubles want it.
Motion Bench::altered(double time, const AxisControl& controller, const Motion& motion) {
  Motion out = motion;
  const auto size = [&](Trouble trouble) { return controller.troubles.at(trouble); };
  const bool swings = out.kind == Kind::sine || out.kind == Kind::sweep || out.kind == Kind::random;
  if (controller.has(Trouble::wrong_set_point) && !swings) target_of(out) += size(Trouble::wrong_set_point);
  if (controller.has(Trouble::slow) && controller.is_air()) {
    const double speed = out.kind == Kind::ramp ? out.value : ramp_limit(plan->rig);
    out = {.kind = Kind::ramp, .value = speed * size(Trouble::slow), .to = target_of(out)};
  }
  if (controller.has(Trouble::overshoot) && goes_somewhere(out)) {
    const double way = target_of(out) - drive(time, controller.axis.name).value;
    if (way != 0.0) target_of(out) += std::copysign(size(Trouble::overshoot), way);
  }
  if (controller.has(Trouble::drifting_rate) && out.kind == Kind::rate)
    out.value *= 1.0 + size(Trouble::drifting_rate) * std::max(0.0, time - controller.drifts_since);
  return out;
}

Motion Bench::without_turns(double time, AxisControl& controller, Motion motion) {
  const std::string& axis = controller.axis.name;
  const std::string of_axis = plan->rig.has(axis + "_max_acceleration") ? axis + "_" : "";
  const bool has_stop = plan->rig.has(of_axis + "lowest") || plan->rig.has(of_axis + "highest");
  if (!controller.turns() || has_stop || !goes_somewhere(motion)) return motion;
  if (controller.demand.kind == Kind::rate) {
    const DriveState now = drive(time, axis);
    const double brakes = plan->rig.number(of_axis + "max_acceleration");
    const double stop = now.value + now.rate * std::abs(now.rate) / (2.0 * brakes);
    controller.whole_turns =
        two_pi * std::round((motion.kind == Kind::slew ? stop : stop - target_of(motion)) / two_pi);
  }
  if (motion.kind == Kind::slew || controller.demand.kind != Kind::rate) target_of(motion) -= controller.whole_turns;
  return motion;
}

/// Closes the running segment. Who is not told anything goes on, or comes to rest.
void Bench::enter(double time, const std::map<std::string, Motion>& changes, bool others_go_on) {
  const double since = time - course().begin();
  std::map<std::string, Motion> next = course().now().axes;
  if (since > course().now_since())
    for (auto& [axis, motion] : next) motion.continued = true;
  if (!others_go_on)
    std::erase_if(next, [&](const auto& entry) { return !control(entry.first).is_air() || since > 0.0; });
  bool anew = false;
  for (const auto& [axis, motion] : changes) {
    const auto standing = course().now().axes.find(axis);
    if (since == 0.0 && course().segments().size() == 1)
      anew |= !begins_at(standing == course().now().axes.end() ? nullptr : &standing->second, motion);
    next[axis] = motion;
  }
  course().change(since, std::move(next), anew);
}

/// What follows from a command without a further one.
void Bench::plan_later(double time, const std::string& axis, const Motion& motion, double trips_after) {
  const AxisControl& controller = control(axis);
  const auto add = [&](double when, Later what) {
    what.axis = axis;
    what.commands = controller.commands;
    later.emplace(when, std::move(what));
  };
  if (std::isfinite(trips_after)) add(time + trips_after, {.what = Later::What::trip});
  if (motion.kind == Kind::sweep && motion.lasts > 0.0)
    add(time + motion.lasts, {.motion = stop_of(controller, drive(time, axis).value)});
  if (controller.has(Trouble::drifting_rate) && motion.kind == Kind::rate)
    add(time + first_drift, {.what = Later::What::drift});
  const bool passes = controller.has(Trouble::overshoot), swings = controller.has(Trouble::never_settles);
  if ((passes || swings) && goes_somewhere(motion) && !controller.is_air()) {
    const double there = std::max(time, course().begin() + course().settled());
    if (passes) add(there, {.motion = motion});
    if (swings)
      add(there + (passes ? 1.0 : 0.0), {.motion = {.kind = Kind::sine,
                                                    .amplitude = controller.troubles.at(Trouble::never_settles),
                                                    .frequency = swing_frequency}});
  } else if (swings) {
    add(time + (controller.is_air() ? swing_of_air : swing_of_rate), {.what = Later::What::swing});
  }
}

void Bench::apply(double time, const std::string& axis, const Motion& motion, double trips_after) {
  AxisControl& controller = control(axis);
  ++controller.commands;
  if (controller.has(Trouble::stuck)) return;
  enter(time, {{axis, altered(time, controller, motion)}}, true);
  plan_later(time, axis, motion, trips_after);
}

void Bench::carry(double time, const Later& what) {
  AxisControl& controller = control(what.axis);
  const auto again = [&](double after, double sense) {
    later.emplace(time + after, Later{what.what, what.axis, what.commands, {}, sense});
  };
  Motion motion = what.motion;
  switch (what.what) {
    case Later::What::trip:
      halt(time, what.axis);
      controller.enabled = false;
      controller.fault = "limit";
      return;
    case Later::What::drift:
      motion = altered(time, controller, controller.demand);
      again(std::max(first_drift, drift_growth * (time - controller.drifts_since)), 1.0);
      break;
    case Later::What::swing:
      motion = altered(time, controller, controller.demand);
      target_of(motion) += what.sense * controller.troubles.at(Trouble::never_settles);
      again(controller.is_air() ? swing_of_air : swing_of_rate, -what.sense);
      break;
    case Later::What::motion:
      break;
  }
  enter(time, {{what.axis, motion}}, true);
}

Refusal Bench::command(double time, const std::string& axis, const Motion& motion) {
  advance(time);
  if (!axes.contains(axis)) {
    std::string names;
    for (const auto& [name, controller] : axes) names += (names.empty() ? "" : ", ") + name;
    return fmt::format("there is no axis '{}'; the rig has {}", axis, names);
  }
  AxisControl& controller = control(axis);
  if (!controller.fault.empty()) return fmt::format("{} has a fault: {}", axis, controller.fault);
  if (!controller.enabled) return fmt::format("{} is disabled", axis);
  if (controller.has(Trouble::refuses)) return fmt::format("{} refuses", axis);
  const bool by_hand = is_mount_axis(axis) && !drive(time, axis).reached;
  if (by_hand) return fmt::format("{}: the instrument is being moved", axis);
  double trips_after = HUGE_VAL;
  if (const Refusal refusal = refusal_of(time, axis, motion, trips_after); !refusal.empty()) return refusal;
  const Motion told = without_turns(time, controller, motion);
  if (controller.is_air()) soaks_since = time;
  controller.demand = told;
  controller.told = true;
  apply(time, axis, told, trips_after);
  return {};
}

Refusal Bench::carry_out(double time, const Segment& segment) {
  advance(time);
  Refusal all;
  std::map<std::string, Motion> changes;
  std::map<std::string, double> trips;
  for (auto [axis, motion] : segment.axes) {
    if (motion.kind == Kind::sweep && !(motion.lasts > 0.0)) motion.lasts = segment.duration;
    const bool known = axes.contains(axis);
    const bool refuses = known && (control(axis).has(Trouble::refuses) || !control(axis).enabled);
    Refusal refusal = refuses ? fmt::format("{} refuses", axis)
                      : known ? refusal_of(time, axis, motion, trips[axis])
                              : fmt::format("there is no axis '{}'", axis);
    if (!refusal.empty()) all += (all.empty() ? "" : "; ") + refusal;
    changes[axis] = motion;
  }
  if (!all.empty()) return all;
  std::map<std::string, Motion> made;
  for (auto& [name, controller] : axes) {
    const auto change = changes.find(name);
    if (change == changes.end() && controller.is_air()) continue;
    if (change == changes.end() && !controller.told) continue;
    ++controller.commands;
    if (change == changes.end()) {
      controller.demand = controller.turns() ? Motion{.kind = Kind::rate} : standstill(time, name);
      continue;
    }
    controller.demand = change->second;
    controller.told = true;
    if (controller.is_air()) soaks_since = time;
    if (!controller.has(Trouble::stuck)) made[name] = altered(time, controller, change->second);
  }
  enter(time, made, false);
  for (const auto& [axis, motion] : made) plan_later(time, axis, changes.at(axis), trips[axis]);
  return {};
}

void Bench::halt(double time, const std::string& axis) {
  AxisControl& controller = control(axis);
  ++controller.commands;
  controller.demand = stop_of(controller, drive(time, axis).value);
  controller.told = true;
  if (controller.has(Trouble::stuck) || is_mount_axis(axis)) return;
  enter(time, {{axis, controller.demand}}, true);
}

void Bench::begin(double time, const std::string& axis, Trouble trouble, double size) {
  advance(time);
  AxisControl& controller = control(axis);
  if (trouble == Trouble::frozen_reading) controller.frozen = reading(time, axis);
  if (trouble == Trouble::drifting_rate) controller.drifts_since = time;
  if (trouble == Trouble::limit_trip || trouble == Trouble::alarm) {
    halt(time, axis);
    controller.enabled = false;
    controller.fault = trouble == Trouble::alarm ? "alarm" : "limit";
    return;
  }
  controller.troubles[trouble] = size;
  const bool at_once = trouble == Trouble::drifting_rate || trouble == Trouble::never_settles ||
                       trouble == Trouble::slow || trouble == Trouble::wrong_set_point;
  if (at_once && controller.told) apply(time, axis, controller.demand, HUGE_VAL);
}

void Bench::end(double time, const std::string& axis, Trouble trouble) {
  advance(time);
  AxisControl& controller = control(axis);
  if (trouble == Trouble::frozen_reading) controller.frozen.reset();
  if (trouble == Trouble::limit_trip || trouble == Trouble::alarm) {
    controller.fault.clear();
    controller.enabled = true;
    return;
  }
  if (controller.troubles.erase(trouble) == 0 || !controller.told) return;
  if (trouble == Trouble::frozen_reading || trouble == Trouble::refuses) return;
  apply(time, axis, controller.demand, HUGE_VAL);
}

}  // namespace tumble::virtual_rig
