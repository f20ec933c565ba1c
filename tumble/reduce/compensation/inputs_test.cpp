#include "tumble/reduce/compensation/inputs.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/reduce/testing/trial_plan.hpp"

namespace tumble::compensation {
namespace {

/// Specific force along x at each second, where the segments "a" and "b" of a plan with 10 s each were recorded for 13
/// s each, and "a" has this motion. "b" holds 90 deg.
std::vector<double> force_along_x(const Motion& first) {
  Plan plan = trial_plan("accelerometer_tumble", {}, "pendulous_accelerometer", "dividing_head", 1.0);
  plan.rig.set_flag("ideal", true);
  plan.schedule = {{"a", 10.0, 1, {{"head", first}}}, {"b", 10.0, 1, {{"head", {.value = si(90.0, "deg")}}}}};
  Recording recording;
  recording.marks = {{"a", 100.0, 1}, {"b", 113.0, 1}};
  Channel output{"accelerometer", QuantityKind::other, Unit::parse("mA"), {100.0, 1.0, nullptr}, {}};
  output.values.assign(26, 0.0);
  recording.channels = {output};
  const auto slots = common_slots();
  const Inputs inputs = inputs_of({}, recording, recording.channels[0], &plan, slots, {});
  std::vector<double> force, values(slots.size());
  for (std::size_t i = 0; i < output.values.size(); ++i) {
    inputs.fill(i, values);
    force.push_back(values[static_cast<std::size_t>(Input::specific_force_x)]);
  }
  return force;
}

TEST(PlannedInputs, OfARestThatTookLongerThanPlannedAreThoseOfTheRest) {
  const auto force = force_along_x({.value = 0.0});
  for (const std::size_t second : {10u, 11u, 12u}) EXPECT_NEAR(force[second], force[9], 1e-9) << second;
  EXPECT_GT(std::abs(force[22] - force[9]), 9.0) << "the next segment has another position";
  for (const std::size_t second : {23u, 24u, 25u}) EXPECT_NEAR(force[second], force[22], 1e-9) << second;
}

TEST(PlannedInputs, OfAMotionThatTookLongerThanPlannedAreNotKnown) {
  const auto force = force_along_x({.kind = Motion::Kind::rate, .value = si(1.0, "deg/s")});
  EXPECT_TRUE(std::isfinite(force[9]));
  for (const std::size_t second : {10u, 11u, 12u}) EXPECT_TRUE(std::isnan(force[second])) << second;
  EXPECT_TRUE(std::isfinite(force[22]));
}

}  // namespace
}  // namespace tumble::compensation
