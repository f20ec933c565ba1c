// Recordings whose segments begin while the axis is under way: the mark of a simulated segment is moved to a later
// time, and the plan says that the segment begins there.
#include "tumble/reduce/table/recorded_turns.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::table {
namespace {

constexpr double late = 10.5;  ///< [s] the segment began before it was recorded

Plan plan_of_motion(const Motion& motion, double duration, bool ideal) {
  Plan plan = trial_plan("rlg_north_finder", {}, "ring_laser_gyro", "two_axis_table", 2.0);
  plan.rig.set_flag("ideal", ideal);
  plan.schedule = {{"rest", 20.0, 1, {{"outer", {.value = 0.0}}, {"inner", {.value = 0.3}}}},
                   {"moves", duration, 1, {{"inner", motion}}}};
  return plan;
}

/// The segment as recorded from `late` on.
Evidence under_way(const Motion& motion, bool ideal = true) {
  Evidence evidence;
  evidence.recordings = {simulate(plan_of_motion(motion, 100.0 + late, ideal), 5, {})};
  evidence.recordings[0].marks[1].begin += late;
  evidence.plan = plan_of_motion(motion, 100.0, ideal);
  return evidence;
}

const Motion& motion_of(const RecordedTurns& turns) { return turns.plan.schedule.at(1).axes.at("inner"); }

/// Where the axis of these recordings is at a rate: it took rate/acceleration to come to it.
double angle_at(double rate, double time, const Plan& plan) {
  return 0.3 + rate * time - 0.5 * rate * std::abs(rate) / plan.rig.number("inner_max_acceleration");
}

TEST(RecordedTurns, ARateGoesOnFromTheAngleOfTheEncoder) {
  for (const double degrees : {3.0, -70.0}) {
    const double rate = si(degrees, "deg/s");
    const Evidence evidence = under_way({.kind = Motion::Kind::rate, .value = rate});
    const auto turns = recorded_turns(evidence);
    ASSERT_EQ(turns.findings.size(), 1u);
    EXPECT_EQ(turns.findings[0].code, "turn_phase_recorded");
    ASSERT_TRUE(motion_of(turns).from);
    // an ideal encoder without steps: rounding of the sum of some 200 points on the circle remains
    const double truth = angle_at(rate, late, evidence.plan);
    EXPECT_NEAR(std::remainder(*motion_of(turns).from - truth, two_pi), 0.0, 1e-11) << degrees;
    EXPECT_LT(std::abs(*motion_of(turns).from - 0.3), two_pi) << "on the turn that the plan has come to";
  }
}

/// An error of the rate adds up to degrees here; half of them would remain where it counted from the beginning. The
/// rate is explained by the plan, whose own remains.
TEST(RecordedTurns, TheAngleOfARateIsKnownInTheMiddleOfItsReadings) {
  const Motion turning{.kind = Motion::Kind::rate, .value = si(40.0, "deg/s")};
  Evidence evidence = under_way({.kind = Motion::Kind::rate, .value = turning.value * (1.0 + 1e-4)});
  evidence.plan = plan_of_motion(turning, 100.0, true);
  evidence.plan.rig.set_number("rate_error_sd", 2e-5, Unit::parse("ppm"));
  const auto turns = recorded_turns(evidence);
  const Motion& found = motion_of(turns);
  ASSERT_TRUE(found.from);
  EXPECT_EQ(found.value, turning.value);
  const double settled = turning.value / evidence.plan.rig.number("inner_max_acceleration");
  EXPECT_NEAR(0.5 * found.lasts, 0.5 * (settled + 100.0), 0.5) << "readings from `settled` to the end, 2 a second";
  const double middle = 0.5 * found.lasts;
  const double truth = angle_at(turning.value * (1.0 + 1e-4), late + middle, evidence.plan);
  EXPECT_NEAR(std::remainder(*found.from + turning.value * middle - truth, two_pi), 0.0, 1e-9);
}

/// The error of the plan's rate is 1 ppm; the axis is 100 ppm off.
TEST(RecordedTurns, ARateThatThePlanDoesNotExplainIsThatOfTheEncoder) {
  const Motion turning{.kind = Motion::Kind::rate, .value = si(40.0, "deg/s")};
  Evidence evidence = under_way({.kind = Motion::Kind::rate, .value = turning.value * (1.0 + 1e-4)});
  evidence.plan = plan_of_motion(turning, 100.0, true);
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_EQ(turns.findings[0].code, "turn_rate_recorded");
  EXPECT_NE(turns.findings[0].message.find("100 ppm"), std::string::npos) << turns.findings[0].message;
  const Motion& found = motion_of(turns);
  EXPECT_NEAR(found.value / turning.value, 1.0 + 1e-4, 1e-11);
  const double middle = 0.5 * found.lasts, truth = angle_at(found.value, late + middle, evidence.plan);
  EXPECT_NEAR(std::remainder(*found.from + found.value * middle - truth, two_pi), 0.0, 1e-9);
}

/// Readings in steps of 0.01 deg: one step within the segment is no other rate, 0.4 deg are.
TEST(RecordedTurns, AStepOfTheEncoderIsNoRate) {
  const Motion turning{.kind = Motion::Kind::rate, .value = si(40.0, "deg/s")};
  for (const auto& [departure, seen] : {std::pair{5e-6, false}, std::pair{1e-4, true}}) {
    Evidence evidence = under_way({.kind = Motion::Kind::rate, .value = turning.value * (1.0 + departure)});
    evidence.plan = plan_of_motion(turning, 100.0, true);
    evidence.plan.rig.set_number("rate_error_sd", 0.0, Unit::parse("ppm"));
    const double step = si(0.01, "deg");
    for (auto& channel : evidence.recordings[0].channels)
      if (channel.name == "inner_angle")
        for (double& angle : channel.values) angle = step * std::round(angle / step);
    EXPECT_EQ(motion_of(recorded_turns(evidence)).value != turning.value, seen) << departure;
  }
}

TEST(RecordedTurns, ReadingsWithinOneTurnSayTheSame) {
  const Motion turning{.kind = Motion::Kind::rate, .value = si(40.0, "deg/s")};
  Evidence evidence = under_way(turning);
  const double counted = *motion_of(recorded_turns(evidence)).from;
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "inner_angle")
      for (double& angle : channel.values) angle -= two_pi * std::floor(angle / two_pi);
  EXPECT_NEAR(*motion_of(recorded_turns(evidence)).from, counted, 1e-11);
}

TEST(RecordedTurns, AnOscillationHasTheMiddleAndThePhaseOfTheEncoder) {
  const Motion oscillating{.kind = Motion::Kind::sine, .amplitude = si(-20.0, "deg"), .frequency = 0.13, .phase = 0.4};
  const auto turns = recorded_turns(under_way(oscillating));
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_NEAR(*motion_of(turns).from, 0.3, 1e-9);
  EXPECT_NEAR(std::remainder(motion_of(turns).phase - 0.4 - two_pi * 0.13 * late, two_pi), 0.0, 1e-9);
}

TEST(RecordedTurns, WhatTheRigsErrorsExplainRemainsAsPlanned) {
  for (const auto& motion : {Motion{.kind = Motion::Kind::rate, .value = si(70.0, "deg/s")},
                             Motion{.kind = Motion::Kind::sine, .amplitude = 0.3, .frequency = 0.13, .phase = 0.4}}) {
    Evidence evidence{plan_of_motion(motion, 100.0, false), {}};
    evidence.recordings = {simulate(evidence.plan, 7, {})};
    EXPECT_TRUE(recorded_turns(evidence).findings.empty());
  }
}

// A table that needs 3 % longer to come to 20 deg/s is 0.09 deg behind: far more than its encoder and its drive are off.
TEST(RecordedTurns, ATableSlowerThanItsPlanIsWhereItsEncoderShowsIt) {
  const Motion turning{.kind = Motion::Kind::rate, .value = si(20.0, "deg/s")};
  Evidence evidence{plan_of_motion(turning, 60.0, true), {}};
  Plan slow = evidence.plan;
  const double limit = slow.rig.number("inner_max_acceleration") / 1.03;
  slow.rig.set_number("inner_max_acceleration", limit, Unit::parse("deg/s^2"));
  evidence.recordings = {simulate(slow, 7, {})};
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_EQ(turns.findings[0].code, "turn_phase_recorded");
  EXPECT_NEAR(std::remainder(*motion_of(turns).from - angle_at(turning.value, 0.0, slow), two_pi), 0.0, 1e-6);
}

TEST(RecordedTurns, ReadingsOfAnotherMotionAreAnErrorWithBothNumbers) {
  Evidence evidence = under_way({.kind = Motion::Kind::rate, .value = si(70.0, "deg/s")});
  evidence.plan.schedule[1].axes["inner"].value = si(50.0, "deg/s");
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_EQ(turns.findings[0].severity, Finding::Severity::error);
  EXPECT_NEAR(value_of(turns.findings, "another_motion_recorded", "recorded"), si(70.0, "deg/s"), 1e-6);
  EXPECT_NEAR(value_of(turns.findings, "another_motion_recorded", "planned"), si(50.0, "deg/s"), 1e-12);
  EXPECT_EQ(motion_of(turns).value, si(50.0, "deg/s")) << "the plan's own";
}

/// 3 % fast, and an oscillation of 19.4 deg for 20 deg: what a table does whose gain is set wrong.
TEST(RecordedTurns, ARateAndAnAmplitudeThatAreOffByPerCentAreThoseOfTheEncoder) {
  Evidence fast = under_way({.kind = Motion::Kind::rate, .value = si(41.2, "deg/s")});
  fast.plan.schedule[1].axes["inner"].value = si(40.0, "deg/s");
  EXPECT_NEAR(motion_of(recorded_turns(fast)).value, si(41.2, "deg/s"), 1e-9);
  Motion oscillating{.kind = Motion::Kind::sine, .amplitude = si(19.4, "deg"), .frequency = 0.13};
  Evidence small = under_way(oscillating);
  small.plan.schedule[1].axes["inner"].amplitude = si(20.0, "deg");
  const auto turns = recorded_turns(small);
  EXPECT_NEAR(motion_of(turns).amplitude, si(19.4, "deg"), 1e-9);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_EQ(turns.findings[0].severity, Finding::Severity::warning);
  EXPECT_NEAR(value_of(turns.findings, "oscillation_recorded", "recorded"), si(19.4, "deg"), 1e-9);
  EXPECT_NEAR(value_of(turns.findings, "oscillation_recorded", "planned"), si(20.0, "deg"), 1e-12);
}

TEST(RecordedTurns, AFrequencyIsThatOfTheEncoder) {
  Motion oscillating{.kind = Motion::Kind::sine, .amplitude = si(20.0, "deg"), .frequency = 0.1303};
  for (const double ratio : {1.0001, 1.02}) {
    Evidence evidence = under_way(oscillating);
    evidence.plan.schedule[1].axes["inner"].frequency = oscillating.frequency / ratio;
    const Motion found = motion_of(recorded_turns(evidence));
    EXPECT_NEAR(found.frequency, oscillating.frequency, 1e-9) << ratio;
    EXPECT_NEAR(std::remainder(found.phase - two_pi * oscillating.frequency * late, two_pi), 0.0, 1e-6) << ratio;
  }
}

Plan plan_of_stands() {
  Plan plan = trial_plan("accelerometer_dynamic", {}, "pendulous_accelerometer", "two_axis_table", 2.0);
  for (const double degrees : {0.0, 30.0, 90.0, 135.0, 210.0, 300.0})
    plan.schedule.push_back({std::to_string(degrees), 60.0, 1, {{"inner", {.value = si(degrees, "deg")}}}});
  return plan;
}

/// Stands that the rig explains remain as planned; a position that was taken twice is the recorded one.
TEST(RecordedTurns, AStandThatTheRigDoesNotExplainIsThatOfTheEncoder) {
  const Plan plan = plan_of_stands();
  Evidence evidence{plan, {simulate(plan, 3, {})}};
  EXPECT_TRUE(recorded_turns(evidence).findings.empty());
  Plan other = plan;
  other.schedule[4].axes["inner"].value = other.schedule[3].axes["inner"].value;
  evidence.recordings = {simulate(other, 3, {})};
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_NEAR(value_of(turns.findings, "angle_off_plan", "recorded"), si(135.0, "deg"), 5.0 * arcsecond);
  EXPECT_NEAR(value_of(turns.findings, "angle_off_plan", "commanded"), si(210.0, "deg"), 1e-12);
  EXPECT_NEAR(turns.plan.schedule[4].axes.at("inner").value, si(135.0, "deg"), 5.0 * arcsecond);
}

TEST(RecordedTurns, AnEncoderThatCountsTheOtherWayIsSaidAndNotUsed) {
  const Plan plan = plan_of_stands();
  Evidence evidence{plan, {simulate(plan, 3, {})}};
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "inner_angle")
      for (double& angle : channel.values) angle = -angle;
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_EQ(turns.findings[0].code, "axis_moves_the_other_way");
  EXPECT_EQ(turns.findings[0].severity, Finding::Severity::error);
  EXPECT_EQ(turns.plan.schedule[1].axes.at("inner").value, si(30.0, "deg"));
}

TEST(RecordedTurns, AnEncoderWhoseZeroIsOffIsNamedAndThePlansZeroIsUsed) {
  const Plan plan = plan_of_stands();
  Evidence evidence{plan, {simulate(plan, 3, {})}};
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "inner_angle")
      for (double& angle : channel.values) angle += 60.0 * arcsecond;
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_NEAR(value_of(turns.findings, "encoder_zero_off_plan", "offset"), 60.0 * arcsecond, 2.0 * arcsecond);
  EXPECT_EQ(turns.plan.schedule[1].axes.at("inner").value, si(30.0, "deg"));
}

// A plan that writes one angle twice in succession says that the axis stays: the encoder shows that it did not.
TEST(RecordedTurns, AnAxisThatMovedWhereThePlanHasItStayIsNamed) {
  const Plan carried_out = plan_of_stands();
  Evidence evidence{carried_out, {simulate(carried_out, 3, {})}};
  auto& schedule = evidence.plan.schedule;
  const double there = schedule[2].axes.at("inner").value;
  schedule[2].axes.at("inner").value = schedule[1].axes.at("inner").value;
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.findings.size(), 1u);
  EXPECT_EQ(turns.findings[0].code, "angle_off_plan");
  EXPECT_NEAR(turns.plan.schedule[2].axes.at("inner").value, there, 30.0 * arcsecond);
}

TEST(RecordedTurns, RepetitionsHaveThePhasesOfTheirOwn) {
  const double rate = si(70.0, "deg/s");
  Evidence evidence = under_way({.kind = Motion::Kind::rate, .value = rate});
  evidence.recordings.push_back(evidence.recordings[0]);
  evidence.recordings[1].marks[1].begin += 1.0;
  const auto turns = recorded_turns(evidence);
  ASSERT_EQ(turns.plans.size(), 2u);
  EXPECT_EQ(turns.plans[0], nullptr);
  ASSERT_NE(turns.plans[1], nullptr);
  const double first = *motion_of(turns).from, second = *turns.plans[1]->schedule[1].axes.at("inner").from;
  EXPECT_NEAR(std::remainder(second - first - rate, two_pi), 0.0, 1e-11);
}

}  // namespace
}  // namespace tumble::table
