#include "tumble/rigs/chain/chain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/earth/earth.hpp"

namespace tumble::chain {
namespace {

using Kind = Motion::Kind;

/// Where the instrument is, from the angles alone: written a second time, without any rate.
struct Pose6 {
  Rotation instrument_from_inertial;
  Vector3 position;  ///< in inertial axes, from the ground's origin
};

double joint_angle(const Joint& joint, double axis) {
  double angle = joint.share * axis + joint.zero;
  for (const auto& h : joint.harmonics)
    angle += h.cosine * std::cos(h.order * axis) + h.sine * std::sin(h.order * axis);
  return angle;
}

Pose6 pose_at(const Chain& chain, double time) {
  const double w = norm(chain.ground.rate);
  Rotation r = about((1.0 / w) * chain.ground.rate, w * time);
  Vector3 p;
  std::size_t hint = 0;
  for (const auto& joint : chain.joints) {
    Vector3 offset = joint.offset;
    const double rate = at(chain.axes[0], time, hint).rate;
    offset.x += joint.stretch * rate * rate;
    p = p + inverse(r) * offset;
    r = joint.fixed * r;
    if (joint.axis < 0) continue;
    const double angle = joint_angle(joint, at(chain.axes[static_cast<std::size_t>(joint.axis)], time, hint).angle);
    if (joint.about == About::x) r = about_x(angle) * r;
    if (joint.about == About::y) r = about_y(angle) * r;
    if (joint.about == About::z) r = about_z(angle) * r;
  }
  p = p + inverse(r) * chain.lever;
  return {chain.poses.front().instrument_from_fixture * r, p};
}

/// Three axes that change their rates, bent and offset joints, wobble, stretch.
Chain moving_chain() {
  Chain chain;
  chain.ground = {{0.3e-4, 0.5e-4, 0.4e-4}, {}, {0.0, 0.0, 9.8}};
  const Schedule run{{"s",
                      20.0,
                      1,
                      {{"a", {.kind = Kind::rate, .value = 6.0}},
                       {"b", {.kind = Kind::sine, .amplitude = 0.4, .frequency = 0.7}},
                       {"c", {.kind = Kind::rate, .value = -4.0}}}}};
  for (const char* axis : {"a", "b", "c"}) chain.axes.push_back(profile_of(run, {axis, 20.0, 1.0}, {}, nullptr));
  chain.joints = {
      {.fixed = about_x(0.2), .axis = 0, .about = About::z, .harmonics = {{1, 0.01, 0.02}, {2, 0.003, 0.0}}},
      {.offset = {2.5, 0.1, -0.2}, .stretch = 1e-3, .fixed = about_y(0.3), .axis = 1, .about = About::x},
      {.axis = 1, .about = About::y, .share = 0.0, .harmonics = {{1, 0.02, 0.01}}},
      {.offset = {0.0, 0.3, 0.0}, .fixed = about_z(-0.4), .axis = 2, .about = About::y, .zero = 0.05}};
  chain.lever = {0.1, -0.2, 0.3};
  chain.poses = {{0.0, about_x(0.1) * about_y(0.2) * about_z(0.3)}};
  return chain;
}

/// Rotation vector of a small rotation.
Vector3 small_turn(const Rotation& r) { return 0.5 * Vector3{r.y.z - r.z.y, r.z.x - r.x.z, r.x.y - r.y.x}; }

// Centripetal, Euler and Coriolis terms, the Earth's included: the trajectory in inertial axes differentiated twice.
// Five-point stencils with h = 1 ms leave h^4/90 x^(6) < 2e-8 m/s^2 here, and 5/h^2 of the rounding of a position: that
// of the angles, 1e-14 rad at 100 rad, on 2.5 m gives 1.3e-7 m/s^2 for each of them.
TEST(Chain, SpecificForceIsTheSecondDerivativeOfTheTrajectory) {
  const Chain chain = moving_chain();
  const double h = 1e-3;
  for (double time = 0.5; time < 19.0; time += 0.37) {
    Felt sample;
    felt(chain, time, 1.0, std::span(&sample, 1));
    Pose6 p[5];
    for (int i = 0; i < 5; ++i) p[i] = pose_at(chain, time + (i - 2) * h);
    const Vector3 acceleration =
        (1.0 / (12.0 * h * h)) * (-1.0 * p[0].position + 16.0 * p[1].position - 30.0 * p[2].position +
                                  16.0 * p[3].position - 1.0 * p[4].position);
    const double w = norm(chain.ground.rate);
    const Rotation level_from_inertial = about((1.0 / w) * chain.ground.rate, w * time);
    const Vector3 support = inverse(level_from_inertial) * chain.ground.specific_force;
    const Vector3 expected = p[2].instrument_from_inertial * (acceleration + support);
    EXPECT_LT(norm(sample.specific_force - expected), 5e-7) << time << ": " << norm(expected);
  }
}

// Central difference of the attitude: h^2/6 w''' < 1e-6 of it at h = 1e-4, taken out by a second step of 2 h.
TEST(Chain, RateTurnsTheInstrumentAndAccelerationChangesTheRate) {
  const Chain chain = moving_chain();
  const auto rate_by_difference = [&](double time, double h) {
    const Rotation before = pose_at(chain, time - h).instrument_from_inertial,
                   after = pose_at(chain, time + h).instrument_from_inertial;
    return (0.5 / h) * small_turn(after * inverse(before));
  };
  const double h = 5e-4;
  for (double time = 0.5; time < 19.0; time += 0.41) {
    Felt sample[3];
    felt(chain, time - h, h, sample);
    const Vector3 extrapolated = (1.0 / 3.0) * (4.0 * rate_by_difference(time, h) - rate_by_difference(time, 2.0 * h));
    EXPECT_LT(norm(sample[1].rate - extrapolated), 1e-8) << time;
    const Vector3 change = (0.5 / h) * (sample[2].rate - sample[0].rate);
    EXPECT_LT(norm(sample[1].angular_acceleration - change), 2e-4) << time;  // h^2/6 w''' with w''' < 2e3 rad/s^4
  }
}

// The same law over the whole time: the attitude that follows from the rates alone is the chain's. Steps of the middle
// rate about a fixed direction: error h^2/12 |w x w'| a second, 1e-7 rad/s at h = 0.1 ms.
TEST(Chain, RatesIntegrateToTheAttitude) {
  const Chain chain = moving_chain();
  const double h = 1e-4;
  std::vector<Felt> samples(100000);
  felt(chain, 2.0 + 0.5 * h, h, samples);
  Rotation attitude = pose_at(chain, 2.0).instrument_from_inertial;
  for (const auto& sample : samples) {
    const double w = norm(sample.rate);
    attitude = about((1.0 / w) * sample.rate, w * h) * attitude;
  }
  const Rotation expected = pose_at(chain, 12.0).instrument_from_inertial;
  EXPECT_LT(norm(small_turn(attitude * inverse(expected))), 1e-6);
}

}  // namespace
}  // namespace tumble::chain
