#include "tumble/rigs/chain/chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tumble::chain {
namespace {

constexpr std::size_t most_axes = 4;
constexpr std::size_t most_joints = 16;  ///< that are looked at once; those beyond at each point

/// v in axes turned about one of them.
template <About about>
Vector3 seen(Vector3 v, double c, double s) {
  if constexpr (about == About::x) return {v.x, c * v.y + s * v.z, c * v.z - s * v.y};
  if constexpr (about == About::y) return {c * v.x - s * v.z, v.y, c * v.z + s * v.x};
  return {c * v.x + s * v.y, c * v.y - s * v.x, v.z};
}

struct Circle {
  double cosine = 1.0, sine = 0.0;
};

/// Of an angle below 0.02 rad by its series: relative error below 1e-17.
Circle circle_of_small(double angle) {
  const double q = angle * angle;
  return {1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0)),
          angle * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0)))};
}

Circle circle_of(double angle) {
  if (std::abs(angle) < 0.02) return circle_of_small(angle);
  return {std::cos(angle), std::sin(angle)};
}

Circle sum(const Circle& a, const Circle& b) {
  return {a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine};
}

/// Where an axis is, with the point on the circle at its angle: at angle 0 until it is moved.
struct AxisState {
  Turn turn;
  Circle circle;

  void move(const Turn& to) {
    if (to.angle != turn.angle) circle = circle_of(to.angle);
    turn = to;
  }
};

template <About about>
Kinematics turned(const Kinematics& k, const Turn& turn, const Circle& at) {
  constexpr Vector3 n{about == About::x ? 1.0 : 0.0, about == About::y ? 1.0 : 0.0, about == About::z ? 1.0 : 0.0};
  const Vector3 w = seen<about>(k.rate, at.cosine, at.sine);
  return {w + turn.rate * n,
          seen<about>(k.acceleration, at.cosine, at.sine) + turn.rate * cross(w, n) + turn.acceleration * n,
          seen<about>(k.specific_force, at.cosine, at.sine)};
}

Kinematics turned(const Kinematics& k, About about, const Turn& turn, const Circle& at) {
  if (about == About::x) return turned<About::x>(k, turn, at);
  if (about == About::y) return turned<About::y>(k, turn, at);
  return turned<About::z>(k, turn, at);
}

/// Turn of a joint from that of its axis.
Kinematics turned(const Kinematics& k, const Joint& joint, const AxisState& axis) {
  double angle = joint.zero, slope = joint.share, curvature = 0.0;
  for (const auto& h : joint.harmonics) {
    const Circle at = h.order == 1   ? axis.circle
                      : h.order == 2 ? sum(axis.circle, axis.circle)
                                     : circle_of(h.order * axis.turn.angle);
    angle += h.cosine * at.cosine + h.sine * at.sine;
    slope += h.order * (h.sine * at.cosine - h.cosine * at.sine);
    curvature -= h.order * h.order * (h.cosine * at.cosine + h.sine * at.sine);
  }
  const double rate = axis.turn.rate;
  const Turn turn{0.0, slope * rate, slope * axis.turn.acceleration + curvature * rate * rate};
  Circle at = joint.share == 1.0 ? axis.circle : Circle{};
  if (angle != 0.0) at = sum(at, circle_of(angle));
  return turned(k, joint.about, turn, at);
}

bool is_zero(Vector3 v) { return v.x == 0.0 && v.y == 0.0 && v.z == 0.0; }

bool is_identity(const Rotation& r) {
  return is_zero(r.x - Vector3{1.0, 0.0, 0.0}) && is_zero(r.y - Vector3{0.0, 1.0, 0.0}) &&
         is_zero(r.z - Vector3{0.0, 0.0, 1.0});
}

/// What a joint does at all, looked at once for many points.
struct JointWork {
  bool shifts = false, leans = false;
};

JointWork work_of(const Joint& joint) { return {!is_zero(joint.offset), !is_identity(joint.fixed)}; }

Kinematics passed(const Kinematics& before, const Joint& joint, JointWork work, std::span<const AxisState> axes) {
  Kinematics k = before;
  if (work.shifts) {
    const double rate = axes[0].turn.rate, acceleration = axes[0].turn.acceleration, s = joint.stretch;
    const Vector3 offset{joint.offset.x + s * rate * rate, joint.offset.y, joint.offset.z};
    k = s == 0.0 ? moved(k, offset)
                 : moved(k, offset, {2.0 * s * rate * acceleration, 0.0, 0.0},
                         {2.0 * s * acceleration * acceleration, 0.0, 0.0});
  }
  if (work.leans) k = seen_in(joint.fixed, k);
  return joint.axis < 0 ? k : turned(k, joint, axes[static_cast<std::size_t>(joint.axis)]);
}

}  // namespace

Kinematics seen_in(const Rotation& new_from_old, const Kinematics& k) {
  return {new_from_old * k.rate, new_from_old * k.acceleration, new_from_old * k.specific_force};
}

Kinematics turned(const Kinematics& k, Vector3 n, const Turn& turn) {
  const Rotation r = about(n, turn.angle);
  const Vector3 w = r * k.rate;
  return {w + turn.rate * n, r * k.acceleration + turn.rate * cross(w, n) + turn.acceleration * n,
          r * k.specific_force};
}

Kinematics moved(const Kinematics& k, Vector3 p, Vector3 velocity, Vector3 acceleration) {
  return {k.rate, k.acceleration,
          k.specific_force + cross(k.acceleration, p) + cross(k.rate, cross(k.rate, p)) +
              2.0 * cross(k.rate, velocity) + acceleration};
}

void felt(const Chain& chain, double first, double step, std::span<Felt> out) {
  std::array<AxisState, most_axes> states{};
  std::array<std::size_t, most_axes> pieces{};
  const std::size_t axes = std::min(chain.axes.size(), most_axes);
  std::array<JointWork, most_joints> works{};
  const std::size_t joints = chain.joints.size(), known = std::min(joints, most_joints);
  for (std::size_t j = 0; j < known; ++j) works[j] = work_of(chain.joints[j]);
  const bool has_lever = !is_zero(chain.lever);
  bool is_mounted = !is_identity(chain.poses.front().instrument_from_fixture);
  std::size_t pose = 0, warm = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double time = first + static_cast<double>(i) * step;
    for (std::size_t a = 0; a < axes; ++a) states[a].move(at(chain.axes[a], time, pieces[a]));
    Kinematics k = chain.ground;
    for (std::size_t j = 0; j < joints; ++j)
      k = passed(k, chain.joints[j], j < known ? works[j] : work_of(chain.joints[j]), states);
    if (has_lever) k = moved(k, chain.lever);
    while (pose + 1 < chain.poses.size() && chain.poses[pose + 1].begin <= time)
      is_mounted = !is_identity(chain.poses[++pose].instrument_from_fixture);
    Felt& felt = out[i];
    felt = {};
    if (is_mounted) k = seen_in(chain.poses[pose].instrument_from_fixture, k);
    felt.rate = k.rate;
    felt.angular_acceleration = k.acceleration;
    felt.specific_force = k.specific_force;
    felt.temperature = felt.start_temperature = chain.temperature;
    if (!chain.oven.pieces.empty()) {
      const Warmth now = at(chain.oven, time, warm);
      felt.temperature = now.temperature;
      felt.temperature_rate = now.rate;
      felt.start_temperature = chain.oven.pieces.front().air;
    }
    felt.since_power_on = time;
  }
}

Vector3 direction_of(About about) {
  return {about == About::x ? 1.0 : 0.0, about == About::y ? 1.0 : 0.0, about == About::z ? 1.0 : 0.0};
}

namespace {

/// Angle of a joint from that of its axis [rad].
double angle_of(const Joint& joint, double turn) {
  double angle = joint.zero + joint.share * turn;
  for (const auto& h : joint.harmonics)
    angle += h.cosine * std::cos(h.order * turn) + h.sine * std::sin(h.order * turn);
  return angle;
}

/// The frame of a joint from that of the joint before.
PartPlacement passed(const PartPlacement& before, const Joint& joint, std::span<const Turn> turns) {
  Vector3 offset = joint.offset;
  if (!turns.empty()) offset.x += joint.stretch * turns[0].rate * turns[0].rate;
  const Rotation fixed = joint.fixed * before.part_from_level;
  const Vector3 origin = before.origin + inverse(before.part_from_level) * offset;
  if (joint.axis < 0) return {fixed, origin};
  const double turn = turns[static_cast<std::size_t>(joint.axis)].angle;
  return {about(direction_of(joint.about), angle_of(joint, turn)) * fixed, origin};
}

PartPlacement passed(const Chain& chain, std::size_t joints, double time) {
  std::vector<Turn> turns;
  for (const auto& axis : chain.axes) {
    std::size_t piece = 0;
    turns.push_back(at(axis, time, piece));
  }
  PartPlacement placement{chain.base, {}};
  for (std::size_t j = 0; j < joints; ++j) placement = passed(placement, chain.joints[j], turns);
  return placement;
}

}  // namespace

PartPlacement joint_at(const Chain& chain, std::size_t joint, double time) { return passed(chain, joint + 1, time); }

PartPlacement instrument_at(const Chain& chain, double time) {
  const PartPlacement fixture = passed(chain, chain.joints.size(), time);
  const auto next = std::upper_bound(chain.poses.begin(), chain.poses.end(), time,
                                     [](double t, const Pose& pose) { return t < pose.begin; });
  const Pose& pose = next == chain.poses.begin() ? chain.poses.front() : *(next - 1);
  return {pose.instrument_from_fixture * fixture.part_from_level,
          fixture.origin + inverse(fixture.part_from_level) * chain.lever};
}

double steady_until(const Chain& chain, double time) {
  double until = std::numeric_limits<double>::infinity();
  for (const auto& axis : chain.axes) until = std::min(until, steady_until(axis, time));
  until = std::min(until, steady_until(chain.oven, time));
  const auto next = std::upper_bound(chain.poses.begin(), chain.poses.end(), time,
                                     [](double t, const Pose& pose) { return t < pose.begin; });
  if (next != chain.poses.end()) until = std::min(until, next->begin);
  return std::max(until, time);
}

}  // namespace tumble::chain
