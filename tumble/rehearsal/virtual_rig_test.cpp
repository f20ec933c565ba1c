#include "tumble/rehearsal/virtual_rig.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using Kind = Motion::Kind;
using Trouble = VirtualRig::Trouble;

constexpr double deg = degree;

Motion hold(double angle) { return {.value = angle}; }
Motion rate(double value) { return {.kind = Kind::rate, .value = value}; }

/// An instrument with noise of every colour on a rig with its usual errors.
Plan plan_of(const char* rig, const char* model, double sample_rate) {
  Plan plan;
  plan.instrument_model = model;
  plan.sample_rate = sample_rate;
  plan.rig_kind = rig;
  plan.rig = defaults(find_rig(rig).options());
  plan.truth = defaults(truth_options(find_model(model)));
  for (const char* name : {"angle_random_walk", "bias_instability", "turn_on_repeatability"})
    for (const char* prefix : {"", "gyro_", "accelerometer_"})
      if (plan.truth.has(std::string(prefix) + name)) plan.truth.set_number(std::string(prefix) + name, 1e-6, Unit{});
  plan.site = Site{.latitude = 0.6, .height = 0.0};
  return plan;
}

/// Position and rate of the table as read, in rad and rad/s; 1e-4 deg of the encoder and its noise are below these.
constexpr double angle_tolerance = 2e-4 * deg, rate_tolerance = 2e-3 * deg;

std::vector<double> values_of(const std::vector<VirtualSamples>& blocks, std::size_t channel) {
  std::vector<double> values;
  for (const auto& block : blocks) {
    const auto& more = block.channels[channel].values;
    values.insert(values.end(), more.begin(), more.end());
  }
  return values;
}

TEST(VirtualRig, GoesToAPositionWithTheAccelerationOfItsAxis) {
  Plan plan = plan_of("rate_table", "imu", 10.0);
  plan.rig.set_number("max_rate", 20.0 * deg, Unit::parse("deg/s"));
  plan.rig.set_number("max_acceleration", 10.0 * deg, Unit::parse("deg/s^2"));
  VirtualRig rig(plan, 1);
  const std::string axis = rig.axes().front();
  EXPECT_EQ(rig.command(1.0, axis, hold(60.0 * deg)), "");
  // 2 s and 20 deg to speed up, 1 s at 20 deg/s, 2 s and 20 deg to brake
  EXPECT_NEAR(rig.reading(3.0, axis).value, 20.0 * deg, angle_tolerance);
  EXPECT_TRUE(rig.reading(3.0, axis).moving);
  EXPECT_NEAR(rig.reading(3.7, axis).rate, 20.0 * deg, rate_tolerance);
  EXPECT_FALSE(rig.reading(5.9, axis).reached);
  const AxisReading there = rig.reading(6.3, axis);
  EXPECT_TRUE(there.reached);
  EXPECT_FALSE(there.moving);
  EXPECT_NEAR(there.value, 60.0 * deg, 20 * arcsecond);  // positioning_sd and index zero of the table: arc seconds
  EXPECT_NEAR(there.rate, 0.0, rate_tolerance);
}

/// A controller counts the turns that its axis has made: a position at a stated speed is the same place as without one.
TEST(VirtualRig, APositionAtASpeedIsWhereTheControllerCountsIt) {
  VirtualRig rig(plan_of("rate_table", "imu", 10.0), 1);
  const std::string axis = rig.axes().front();
  EXPECT_EQ(rig.command(0.0, axis, rate(100.0 * deg)), "");
  const double turned = rig.reading(100.0, axis).value;
  ASSERT_GT(turned, 27.0 * two_pi);
  for (const double time : {100.0, 150.0}) {  // the second without a rate in between
    const double target = turned + 0.01 * time;
    EXPECT_EQ(rig.command(time, axis, {.kind = Kind::slew, .value = 10.0 * deg, .to = target}), "");
    const AxisReading there = rig.reading(time + 49.0, axis);
    EXPECT_TRUE(there.reached);
    EXPECT_NEAR(there.value, target, 20 * arcsecond);  // positioning and index zero of the table: arc seconds
  }
  EXPECT_EQ(rig.command(200.0, axis, hold(turned)), "");
  EXPECT_NEAR(rig.reading(220.0, axis).value, turned, 20 * arcsecond);
  rig.power(220.0, true);
  EXPECT_NEAR(rig.reading(220.0, axis).value, turned, 20 * arcsecond) << "a power-up moves nothing";
}

/// A run of simulate() begins where its first segment wants the axes; a rig that is told so at its first instant moves.
TEST(VirtualRig, ACommandAtTheFirstInstantIsAMoveToo) {
  for (const bool powered : {false, true}) {
    VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
    if (powered) rig.power(0.0, true);
    rig.command(0.0, "outer", hold(90.0 * deg));
    EXPECT_NEAR(rig.reading(0.0, "outer").value, 0.0, 0.02 * deg);
    EXPECT_TRUE(rig.reading(0.5, "outer").moving);
    EXPECT_NEAR(rig.reading(60.0, "outer").value, 90.0 * deg, 0.02 * deg);
  }
}

TEST(VirtualRig, AStopOnTheWayBrakesAtOnce) {
  Plan plan = plan_of("rate_table", "imu", 10.0);
  plan.rig.set_number("max_acceleration", 10.0 * deg, Unit::parse("deg/s^2"));
  VirtualRig rig(plan, 1);
  const std::string axis = rig.axes().front();
  rig.command(0.0, axis, rate(20.0 * deg));
  EXPECT_EQ(rig.stop(10.0, axis), "");
  // 20 deg in the first 2 s, 160 deg in 8 s, 20 deg in 2 s of braking
  EXPECT_NEAR(rig.reading(12.3, axis).value, 200.0 * deg, 0.02 * deg);  // 100 ppm of 180 deg
  EXPECT_FALSE(rig.reading(12.3, axis).moving);
  EXPECT_NEAR(rig.reading(30.0, axis).value, 200.0 * deg, 0.02 * deg);
}

TEST(VirtualRig, OneAxisIsToldAndTheOthersGoOn) {
  const Plan plan = plan_of("three_axis_table", "imu", 10.0);
  VirtualRig rig(plan, 3), alone(plan, 3);
  for (VirtualRig* one : {&rig, &alone}) one->command(0.0, "outer", rate(10.0 * deg));
  rig.command(4.0, "inner", hold(90.0 * deg));
  rig.command(4.1, "middle", {.kind = Kind::sine, .amplitude = 1.0 * deg, .frequency = 1.0});
  rig.command(20.0, "inner", rate(5.0 * deg));
  for (const double time : {20.5, 33.3})
    EXPECT_NEAR(rig.reading(time, "outer").value, alone.reading(time, "outer").value, angle_tolerance);
  // the sine went on as it was: a full period later the axis is where it was
  EXPECT_NEAR(rig.reading(40.25, "middle").value - rig.reading(41.25, "middle").value, 0.0, angle_tolerance);
  EXPECT_GT(std::abs(rig.reading(42.35, "middle").value - rig.reading(42.85, "middle").value), 0.5 * deg);
}

TEST(VirtualRig, SamplesComeOnceInOrderAndDoNotDependOnWhenTheyAreAskedFor) {
  const Plan plan = plan_of("three_axis_table", "imu", 50.0);
  VirtualRig often(plan, 4), seldom(plan, 4);
  std::vector<VirtualSamples> many, few;
  for (VirtualRig* rig : {&often, &seldom}) {
    rig->power(0.0, true);
    rig->command(0.0, "outer", rate(30.0 * deg));
  }
  for (double time = 0.0; time < 20.0; time += 0.13)
    for (auto& block : often.samples(time)) many.push_back(std::move(block));
  EXPECT_EQ(often.command(20.0, "outer", hold(0.0)), seldom.command(20.0, "outer", hold(0.0)));
  for (double time = 20.0; time < 60.05; time += 0.1)
    for (auto& block : often.samples(time)) many.push_back(std::move(block));
  for (auto& block : seldom.samples(60.05)) few.push_back(std::move(block));
  const auto a = values_of(many, 0), b = values_of(few, 0);
  EXPECT_GE(a.size(), 2990u);
  ASSERT_GE(b.size(), a.size());
  // Those given at once before the command were made as if the rate went on: the last 4 steps may differ in what the
  // mean over a step differs from the value in its middle, here far below 1e-6 rad/s.
  std::size_t differ = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k], b[k], 1e-6);
    differ += a[k] != b[k];
  }
  EXPECT_LE(differ, 4u);
  std::size_t next = 0;
  for (const auto& block : many) {
    EXPECT_EQ(block.first, next);
    EXPECT_NEAR(block.channels[0].timeline.start, static_cast<double>(block.first) / 50.0, 1e-12);
    next += block.size();
  }
}

TEST(VirtualRig, EachPowerUpHasItsOwnTurnOnAndTheRigGoesOn) {
  Plan plan = plan_of("rate_table", "fiber_optic_gyro", 10.0);
  plan.truth.set_number("turn_on_repeatability", 1e-3, Unit::parse("rad/s"));
  plan.rig.set_number("max_acceleration", 10.0 * deg, Unit::parse("deg/s^2"));
  VirtualRig rig(plan, 5);
  const std::string axis = rig.axes().front();
  rig.power(0.0, true);
  rig.command(0.0, axis, rate(10.0 * deg));
  rig.power(30.0, false);
  EXPECT_EQ(rig.power_up(), 0);
  rig.power(32.05, true);  // while it turns
  EXPECT_EQ(rig.power_up(), 2);
  const auto blocks = rig.samples(60.0);
  ASSERT_EQ(blocks.size(), 2u);
  EXPECT_EQ(blocks[0].size(), 300u);
  EXPECT_EQ(blocks[1].power_up, 2);
  EXPECT_EQ(blocks[1].first, 0u);
  EXPECT_NEAR(blocks[1].channels[0].timeline.start, 32.05, 1e-9);
  const double before = blocks[0].channels[0].values[299], after = blocks[1].channels[0].values[10];
  EXPECT_GT(std::abs(before - after), 1e-5);  // the turn-on
  EXPECT_NEAR(before, after, 6e-3);           // and no more than it: the table turns at the same 0.17 rad/s
  EXPECT_NEAR(rig.reading(60.0, axis).value, 595.0 * deg, 0.3 * deg);  // 100 ppm of the rate
}

TEST(VirtualRig, WhatTheRigCannotDoIsRefusedAndChangesNothing) {
  Plan plan = plan_of("three_axis_table", "imu", 10.0);
  plan.rig.set_number("inner_lowest", -100.0 * deg, Unit::parse("deg"));
  plan.rig.set_number("inner_highest", 100.0 * deg, Unit::parse("deg"));
  VirtualRig rig(plan, 1);
  EXPECT_NE(rig.command(0.0, "outer", rate(1e5 * deg)).find("max_rate"), std::string::npos);
  EXPECT_NE(rig.command(0.0, "inner", hold(120.0 * deg)).find("stop at 100 deg"), std::string::npos);
  EXPECT_NE(rig.command(0.0, "inmer", hold(0.0)).find("outer"), std::string::npos);
  EXPECT_NE(rig.command(0.0, "outer", {.kind = Kind::random}).find("cannot random"), std::string::npos);
  EXPECT_NE(rig.command(0.0, "outer", hold(std::nan(""))).find("finite"), std::string::npos);
  EXPECT_NEAR(rig.reading(10.0, "outer").value, 0.0, angle_tolerance);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"10", "9"}}, [&] { rig.reading(9.0, "outer"); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"nothing"}}, [&] { rig.reading(11.0, "nothing"); }));
}

TEST(VirtualRig, AnAxisThatTurnsIntoItsStopTrips) {
  Plan plan = plan_of("three_axis_table", "imu", 10.0);
  plan.rig.set_number("inner_lowest", -100.0 * deg, Unit::parse("deg"));
  plan.rig.set_number("inner_highest", 100.0 * deg, Unit::parse("deg"));
  VirtualRig rig(plan, 1);
  EXPECT_EQ(rig.command(0.0, "inner", rate(10.0 * deg)), "");
  EXPECT_EQ(rig.reading(9.0, "inner").fault, "");
  const AxisReading tripped = rig.reading(20.0, "inner");
  EXPECT_EQ(tripped.fault, "limit");
  EXPECT_FALSE(tripped.moving);
  EXPECT_NEAR(tripped.value, 100.0 * deg, 2.0 * deg);  // and the way to brake
  EXPECT_NE(rig.command(21.0, "inner", hold(0.0)), "");
  rig.clear_fault(22.0, "inner");
  EXPECT_EQ(rig.command(23.0, "inner", hold(0.0)), "");
  EXPECT_NEAR(rig.reading(60.0, "inner").value, 0.0, 0.02 * deg);
}

TEST(VirtualRig, AChamberGoesToItsSetPointAsFastAsItCan) {
  Plan plan = plan_of("thermal_chamber", "fiber_optic_gyro", 1.0);
  plan.rig.set_number("ramp_limit", 0.05, Unit::parse("K/s"));
  VirtualRig rig(plan, 6);
  EXPECT_NEAR(rig.reading(0.0, "chamber").value, 293.15, 0.5);  // as below
  rig.power(10.0, true);
  EXPECT_EQ(rig.command(100.0, "chamber", {.kind = Kind::dwell, .value = 323.15}), "");
  EXPECT_NEAR(rig.reading(400.0, "chamber").value, 308.15, 0.5);  // 5 standard deviations of the air
  EXPECT_TRUE(rig.reading(600.0, "chamber").moving);
  EXPECT_TRUE(rig.reading(800.0, "chamber").reached);
  EXPECT_EQ(rig.command(800.0, "chamber", {.kind = Kind::ramp, .value = 0.01, .to = 313.15}), "");
  EXPECT_NEAR(rig.reading(1300.0, "chamber").value, 318.15, 0.5);
  EXPECT_EQ(rig.stop(1300.0, "chamber"), "");
  EXPECT_NEAR(rig.reading(5000.0, "chamber").value, 318.15, 1.0);
  EXPECT_NE(rig.command(5000.0, "chamber", {.kind = Kind::dwell, .value = 500.0}).find("outside"), std::string::npos);
  EXPECT_NE(rig.command(5000.0, "chamber", {.kind = Kind::ramp, .value = 1.0, .to = 300.0}), "");
}

TEST(VirtualRig, ACopyGoesOnByItself) {
  const Plan plan = plan_of("rate_table", "imu", 10.0);
  VirtualRig rig(plan, 8);
  const std::string axis = rig.axes().front();
  rig.power(0.0, true);
  rig.samples(50.0);
  VirtualRig copy = rig;
  copy.command(60.0, axis, rate(20.0 * deg));
  const auto moved = values_of(copy.samples(100.0), 0), still = values_of(rig.samples(100.0), 0);
  ASSERT_EQ(moved.size(), still.size());
  EXPECT_EQ(std::vector(moved.begin(), moved.begin() + 100), std::vector(still.begin(), still.begin() + 100));
  EXPECT_NEAR(rig.reading(100.0, axis).rate, 0.0, rate_tolerance);
}

/// Every fault of an axis does what it says.
TEST(VirtualRig, AFrozenReadingShowsWhatItShowed) {
  VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
  rig.command(0.0, "outer", rate(10.0 * deg));
  rig.begin(10.0, "outer", Trouble::frozen_reading, 0.0);
  const double shown = rig.reading(10.0, "outer").value;
  EXPECT_EQ(rig.reading(15.0, "outer").value, shown);
  rig.end(20.0, "outer", Trouble::frozen_reading);
  EXPECT_GT(rig.reading(20.1, "outer").value, shown + 90.0 * deg);
}

TEST(VirtualRig, AStuckAxisObeysNothing) {
  VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
  rig.command(0.0, "outer", rate(10.0 * deg));
  rig.begin(10.0, "outer", Trouble::stuck, 0.0);
  EXPECT_EQ(rig.stop(11.0, "outer"), "");
  EXPECT_EQ(rig.command(12.0, "outer", hold(0.0)), "");
  EXPECT_NEAR(rig.reading(20.0, "outer").rate, 10.0 * deg, 0.01 * deg);
  rig.end(21.0, "outer", Trouble::stuck);  // and does what it was told last
  EXPECT_NEAR(std::remainder(rig.reading(60.0, "outer").value, two_pi), 0.0, 0.02 * deg);
}

TEST(VirtualRig, AnOvershootPassesThePositionAndComesBack) {
  VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
  rig.begin(0.0, "outer", Trouble::overshoot, 2.0 * deg);
  rig.command(1.0, "outer", hold(30.0 * deg));
  double highest = 0.0;
  for (double time = 1.0; time < 20.0; time += 0.05) highest = std::max(highest, rig.reading(time, "outer").value);
  EXPECT_NEAR(highest, 32.0 * deg, 0.02 * deg);
  EXPECT_NEAR(rig.reading(20.0, "outer").value, 30.0 * deg, 0.02 * deg);
}

TEST(VirtualRig, AnAxisThatNeverSettlesSwings) {
  VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
  rig.begin(0.0, "outer", Trouble::never_settles, 0.1 * deg);
  rig.command(1.0, "outer", hold(30.0 * deg));
  double lowest = 1e9, highest = -1e9;
  for (double time = 40.0; time < 44.0; time += 0.05) {
    lowest = std::min(lowest, rig.reading(time, "outer").value);
    highest = std::max(highest, rig.reading(time, "outer").value);
  }
  EXPECT_NEAR(highest - lowest, 0.2 * deg, 0.01 * deg);
  rig.end(50.0, "outer", Trouble::never_settles);
  EXPECT_NEAR(rig.reading(60.0, "outer").value, 30.0 * deg, 0.02 * deg);
}

TEST(VirtualRig, ARateThatDriftsGrows) {
  VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
  rig.command(0.0, "outer", rate(10.0 * deg));
  rig.begin(10.0, "outer", Trouble::drifting_rate, 1e-3);
  EXPECT_NEAR(rig.reading(60.0, "outer").rate, 10.5 * deg, 0.02 * deg);
  EXPECT_NEAR(rig.reading(510.0, "outer").rate, 15.0 * deg, 0.15 * deg);  // set anew every 2 % of the time
  rig.end(520.0, "outer", Trouble::drifting_rate);
  EXPECT_NEAR(rig.reading(530.0, "outer").rate, 10.0 * deg, 0.01 * deg);
}

TEST(VirtualRig, TripsAlarmsAndRefusalsAreSaid) {
  VirtualRig rig(plan_of("three_axis_table", "imu", 10.0), 1);
  rig.command(0.0, "outer", rate(10.0 * deg));
  rig.begin(10.0, "outer", Trouble::limit_trip, 0.0);
  EXPECT_EQ(rig.reading(12.0, "outer").fault, "limit");
  EXPECT_FALSE(rig.reading(12.0, "outer").moving);
  EXPECT_NE(rig.command(13.0, "outer", hold(0.0)), "");
  rig.begin(13.0, "inner", Trouble::refuses, 0.0);
  EXPECT_NE(rig.command(14.0, "inner", hold(0.1)), "");
  EXPECT_NE(rig.stop(14.0, "inner"), "");
  rig.end(15.0, "inner", Trouble::refuses);
  EXPECT_EQ(rig.command(15.0, "inner", hold(0.1)), "");
}

TEST(VirtualRig, AChamberMayBeSlowOrWrongOrAlarmed) {
  Plan plan = plan_of("thermal_chamber", "fiber_optic_gyro", 1.0);
  plan.rig.set_number("ramp_limit", 0.05, Unit::parse("K/s"));
  VirtualRig rig(plan, 6);
  rig.begin(0.0, "chamber", Trouble::slow, 0.5);
  rig.command(0.0, "chamber", {.kind = Kind::dwell, .value = 323.15});
  EXPECT_NEAR(rig.reading(400.0, "chamber").value, 303.15, 0.5);  // 5 standard deviations of the air
  rig.end(400.0, "chamber", Trouble::slow);
  rig.begin(400.0, "chamber", Trouble::wrong_set_point, 4.0);
  EXPECT_NEAR(rig.reading(2000.0, "chamber").value, 327.15, 0.5);
  rig.command(2000.0, "chamber", {.kind = Kind::dwell, .value = 293.15});
  rig.begin(2100.0, "chamber", Trouble::alarm, 0.0);
  EXPECT_EQ(rig.reading(2200.0, "chamber").fault, "alarm");
  EXPECT_NEAR(rig.reading(5000.0, "chamber").value, 322.15, 0.7);
}

TEST(VirtualRig, SaysAllThatThePlanLacks) {
  try {
    VirtualRig rig(Plan{}, 1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.size(), 3u);
  }
}

}  // namespace
}  // namespace tumble
