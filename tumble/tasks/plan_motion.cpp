#include "tumble/tasks/plan_motion.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tumble/earth/earth.hpp"
#include "tumble/reduce/stretches.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

Schedule segments_of_run(const Plan& plan, int run) {
  Schedule segments;
  for (const auto& segment : plan.schedule)
    if (segment.run == run) segments.push_back(segment);
  if (segments.empty()) throw Error(Error::Kind::bad_input, say("the schedule has no power-up number {}", run));
  return segments;
}

/// [Hz] at which a rig with a history is asked: some thousand points, for a picture.
double rate_for_picture(const Schedule& segments) {
  double duration = 0.0;
  for (const auto& segment : segments) duration += segment.duration;
  return std::min(1.0, 20'000.0 / std::max(duration, 1.0));
}

Unit unit_of_axis(const Rig& rig, const std::string& name) {
  for (const auto& axis : rig.axes())
    if (axis.name == name) return Unit::parse(axis.unit);
  return Unit::parse("1");
}

}  // namespace

PlanMotion motion_of(const Plan& plan, int run, double first, double step, std::size_t count) {
  if (plan.rig_kind.empty()) throw Error(Error::Kind::bad_input, "the plan names no rig");
  const auto segments = segments_of_run(plan, run);
  const auto power_up = power_up_of(plan, segments, rate_for_picture(segments));
  const auto& reference = power_up.reference;
  const auto time = [&](std::size_t i) { return first + static_cast<double>(i) * step; };
  PlanMotion motion;
  for (const auto& part : reference.parts) {
    motion.parts.push_back({part.name, part.axis, part.slides, {}});
    for (std::size_t i = 0; i < count; ++i) motion.parts.back().at.push_back(part.at(time(i)));
  }
  for (const auto& drive : reference.drives) {
    motion.axes.push_back({drive.axis, unit_of_axis(find_rig(plan.rig_kind), drive.axis), {}});
    for (std::size_t i = 0; i < count; ++i) motion.axes.back().values.push_back(drive.at(time(i)).value);
  }
  motion.settled = reference.settled;
  motion.specific_force = {0.0, 0.0, plan.site ? gravity(*plan.site) : standard_gravity};
  if (plan.site) motion.earth_rate = earth_rate_in_level(*plan.site);
  return motion;
}

}  // namespace tumble
