#pragma once

#include <array>
#include <span>
#include <vector>

#include "tumble/math/step_means.hpp"
#include "tumble/models/model.hpp"

namespace tumble {

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
