#include "tumble/methods/north_finding/attitude.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tumble/earth/earth.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

constexpr double least_vertical = 0.5;  ///< cosine of the tilt of the axis: 60 deg

Felt felt_at(const Reference& reference, double time) {
  Felt felt;
  reference.felt(time, 1e-3, {&felt, 1});
  return felt;
}

Reference world(const PowerUp& power_up, const Matrix& errors, double latitude) {
  RigRun run = power_up.rig;
  run.errors = errors;
  run.site->latitude = latitude;
  run.site->gravity = gravity(*power_up.plan->site);
  return find_rig(power_up.plan->rig_kind).reference(run);
}

Rotation from_columns(Vector3 east, Vector3 north, Vector3 up) { return inverse(Rotation{east, north, up}); }

bool is_angle(const Axis& axis) { return axis.unit == "deg"; }

/// Whether the segments put this axis to different angles, or turn it.
bool turns(const Schedule& schedule, const std::string& axis) {
  constexpr double least = 0.01;  // recorded angles of an axis that stands differ by less
  std::set<double> held;
  for (const auto& segment : schedule) {
    const auto motion = segment.axes.find(axis);
    if (motion == segment.axes.end()) continue;
    const auto kind = motion->second.kind;
    if (kind == Motion::Kind::hold)
      held.insert(motion->second.value);
    else if (kind == Motion::Kind::slew || kind == Motion::Kind::ramp)
      held.insert(motion->second.to);
    else
      return true;
  }
  return !held.empty() && *held.rbegin() - *held.begin() > least;
}

std::string turning_axis(const Plan& plan) {
  std::vector<std::string> axes, angles;
  for (const auto& axis : find_rig(plan.rig_kind).axes()) {
    if (!is_angle(axis)) continue;
    angles.push_back(axis.name);
    if (turns(plan.schedule, axis.name)) axes.push_back(axis.name);
  }
  if (axes.size() == 1) return axes.front();
  const Sentence what = axes.empty() ? Sentence(
                                           "the schedule turns no axis: the method finds north where one gyro points "
                                           "into several directions")
                                     : say("the schedule turns {}", fmt::join(axes, " and "));
  throw Error(Error::Kind::bad_input,
              say("{}; north finding needs one axis of the rig, vertical, that goes to index angles or turns "
                  "(axes of {}: {})",
                  what, Name{plan.rig_kind}, fmt::join(angles, ", ")));
}

}  // namespace

Attitude::Attitude(const PowerUp& power_up, const Matrix& errors)
    : equator_(world(power_up, errors, 0.0)),
      pole_(world(power_up, errors, half_pi)),
      other_pole_(world(power_up, errors, -half_pi)),
      gravity_(gravity(*power_up.plan->site)) {}

Attitude::Vectors Attitude::vectors(double time) const {
  const Felt equator = felt_at(equator_, time), pole = felt_at(pole_, time), other = felt_at(other_pole_, time);
  const Vector3 spin = 0.5 * (pole.rate + other.rate);
  const Vector3 up = (0.5 / earth_rate) * (pole.rate - other.rate);
  return {(1.0 / earth_rate) * (equator.rate - spin), up, spin, equator.specific_force - gravity_ * up};
}

Rotation Attitude::body_from_level(double time) const {
  const auto v = vectors(time);
  return from_columns(cross(v.north, v.up), v.north, v.up);
}

View Attitude::at(double time, const Rotation& base_from_level) const {
  const auto v = vectors(time);
  const Rotation body_from_level = from_columns(cross(v.north, v.up), v.north, v.up);
  return {1.0, body_from_level * inverse(base_from_level), v.spin, v.force};
}

Index index_of(const Plan& plan) {
  const auto axis = turning_axis(plan);
  Segment segment = standing_alone(plan.schedule, 0);
  segment.duration = 1.0;
  segment.axes[axis] = {.kind = Motion::Kind::hold, .value = 0.0};
  PowerUp power_up = power_up_of(plan, {segment}, 1.0);
  const Rotation base = Attitude(power_up, {}).body_from_level(0.5);
  power_up.rig.segments[0].axes[axis].value = 1.0;
  const Rotation turned = Attitude(power_up, {}).body_from_level(0.5) * inverse(base);
  // a passive turn by 1 rad about n has the antisymmetric part sin(1) n
  const Vector3 n{turned.y.z - turned.z.y, turned.z.x - turned.x.z, turned.x.y - turned.y.x};
  if (n.z < 2.0 * std::sin(1.0) * (1.0 - rounding_share) || (base * Vector3{0.0, 0.0, 1.0}).z < least_vertical)
    throw Error(Error::Kind::bad_input,
                say("axis '{}' must be vertical, upwards (up to 60 deg of tilt), and turn the instrument about "
                    "its own z axis: the method counts index angles so. Correct [rig] or the mounting",
                    axis));
  return {axis, base};
}

}  // namespace tumble::north_finding
