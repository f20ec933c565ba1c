#include "tumble/rigs/chain/chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tumble::rigs {
namespace {

constexpr std::size_t most_axes = 4;

/// v in axes turned about one of them.
template <About about>
Vector3 seen(Vector3 v, double c, double s) {
  if constexpr (about == About::x) return {v.x, c * v.y + s * v.z, c * v.z - s * v.y};
  if constexpr (about == About::y) return {c * v.x - s * v.z, v.y, c * v.z + s * v.x};
  return {c * v.x + s * v.y, c * v.y - s * v.x, v.z};
}

template <About about>
Kinematics turned(const Kinematics& k, const Turn& turn) {
  constexpr Vector3 n{about == About::x ? 1.0 : 0.0, about == About::y ? 1.0 : 0.0, about == About::z ? 1.0 : 0.0};
  const double c = std::cos(turn.angle), s = std::sin(turn.angle);
  const Vector3 w = seen<about>(k.rate, c, s);
  return {w + turn.rate * n, seen<about>(k.acceleration, c, s) + turn.rate * cross(w, n) + turn.acceleration * n,
          seen<about>(k.specific_force, c, s)};
}

Kinematics turned(const Kinematics& k, About about, const Turn& turn) {
  if (about == About::x) return turned<About::x>(k, turn);
  if (about == About::y) return turned<About::y>(k, turn);
  return turned<About::z>(k, turn);
}

/// Angle of a joint from that of its axis.
Turn joint_turn(const Joint& joint, const Turn& axis) {
  Turn out{joint.share * axis.angle + joint.zero, 0.0, 0.0};
  double slope = joint.share, curvature = 0.0;
  for (const auto& h : joint.harmonics) {
    const double c = std::cos(h.order * axis.angle), s = std::sin(h.order * axis.angle);
    out.angle += h.cosine * c + h.sine * s;
    slope += h.order * (h.sine * c - h.cosine * s);
    curvature -= h.order * h.order * (h.cosine * c + h.sine * s);
  }
  out.rate = slope * axis.rate;
  out.acceleration = slope * axis.acceleration + curvature * axis.rate * axis.rate;
  return out;
}

bool is_identity(const Rotation& r) { return r.x.x == 1.0 && r.y.y == 1.0 && r.z.z == 1.0; }

Kinematics passed(const Kinematics& before, const Joint& joint, std::span<const Turn> axes) {
  Kinematics k = before;
  if (joint.offset.x != 0.0 || joint.offset.y != 0.0 || joint.offset.z != 0.0) {
    const double rate = axes[0].rate, acceleration = axes[0].acceleration, s = joint.stretch;
    const Vector3 offset{joint.offset.x + s * rate * rate, joint.offset.y, joint.offset.z};
    k = s == 0.0 ? moved(k, offset)
                 : moved(k, offset, {2.0 * s * rate * acceleration, 0.0, 0.0},
                         {2.0 * s * acceleration * acceleration, 0.0, 0.0});
  }
  if (!is_identity(joint.fixed)) k = seen_in(joint.fixed, k);
  return joint.axis < 0 ? k : turned(k, joint.about, joint_turn(joint, axes[static_cast<std::size_t>(joint.axis)]));
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
  std::array<Turn, most_axes> turns{};
  std::array<std::size_t, most_axes> pieces{};
  const std::size_t axes = std::min(chain.axes.size(), most_axes);
  std::size_t pose = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double time = first + static_cast<double>(i) * step;
    for (std::size_t a = 0; a < axes; ++a) turns[a] = at(chain.axes[a], time, pieces[a]);
    Kinematics k = chain.ground;
    for (const auto& joint : chain.joints) k = passed(k, joint, turns);
    k = moved(k, chain.lever);
    while (pose + 1 < chain.poses.size() && chain.poses[pose + 1].begin <= time) ++pose;
    const Rotation& mounted = chain.poses[pose].instrument_from_fixture;
    Felt& felt = out[i];
    felt = {};
    felt.rate = mounted * k.rate;
    felt.angular_acceleration = mounted * k.acceleration;
    felt.specific_force = mounted * k.specific_force;
    felt.temperature = felt.start_temperature = chain.temperature;
    felt.since_power_on = time;
  }
}

double steady_until(const Chain& chain, double time) {
  double until = std::numeric_limits<double>::infinity();
  for (const auto& axis : chain.axes) until = std::min(until, steady_until(axis, time));
  for (const auto& pose : chain.poses)
    if (pose.begin > time) until = std::min(until, pose.begin);
  return std::max(until, time);
}

}  // namespace tumble::rigs
