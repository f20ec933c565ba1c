#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "tumble/core/schedule.hpp"
#include "tumble/math/step_means.hpp"
#include "tumble/models/model.hpp"

namespace tumble {

/// Whether what is felt in a segment goes on smoothly: an axis turns at a rate or oscillates. Moves from rest to rest
/// keep the sum of their middles, which is their angle, and noise is resolved by its steps.
inline bool goes_on(const Segment& segment) {
  return std::ranges::any_of(segment.axes, [](const auto& axis) {
    return axis.second.kind == Motion::Kind::rate || axis.second.kind == Motion::Kind::sine;
  });
}

/// The course of what is felt over evenly spaced steps: of rate [rad/s] and specific force [10 m/s^2] together. Given:
/// felt in the middle of each step.
inline std::vector<StepCourse> courses_of(std::span<const Felt> felt) {
  std::vector<std::array<double, 6>> signals;
  signals.reserve(felt.size());
  for (const Felt& one : felt) {
    const Vector3 rate = one.rate, force = 0.1 * one.specific_force;
    signals.push_back({rate.x, rate.y, rate.z, force.x, force.y, force.z});
  }
  return courses_of(signals);
}

}  // namespace tumble
