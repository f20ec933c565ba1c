#include "tumble/sim/simulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/models/model.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Two power-ups of a fibre-optic gyro with every kind of noise in a chamber.
Plan plan_with_noise() {
  Plan plan;
  plan.instrument_model = "fiber_optic_gyro";
  plan.sample_rate = 2.0;
  plan.rig_kind = "thermal_chamber";
  plan.rig = defaults(find_rig(plan.rig_kind).options());
  for (const int run : {1, 2})
    plan.schedule.push_back({"dwell", 900.0, run, {{"chamber", {.kind = Motion::Kind::dwell, .value = 300.0}}}});
  plan.truth = defaults(truth_options(find_model(plan.instrument_model)));
  for (const char* name : {"angle_random_walk", "bias_instability", "rate_random_walk", "quantization_noise",
                           "markov_sd", "rate_ramp", "turn_on_repeatability", "A1_0"})
    plan.truth.set_number(name, 1e-6, Unit{});
  return plan;
}

TEST(Simulate, GivesTheSameSamplesInBlocksAsAtOnce) {
  const Plan plan = plan_with_noise();
  const Recording whole = simulate(plan, 5, {});
  Recording joined;
  simulate(plan, 5, 777,
           [&](const Recording& block) {
             if (joined.channels.empty()) {
               joined = block;
               return;
             }
             for (std::size_t c = 0; c < block.channels.size(); ++c) {
               auto& to = joined.channels[c];
               const auto& from = block.channels[c];
               EXPECT_LE(from.values.size(), 777u);
               EXPECT_NEAR(from.timeline.start, to.timeline.time(to.values.size()), 1e-6);
               to.values.insert(to.values.end(), from.values.begin(), from.values.end());
             }
           },
           {});
  ASSERT_EQ(joined.channels.size(), whole.channels.size());
  ASSERT_EQ(joined.marks.size(), whole.marks.size());
  std::size_t bytes = 0;
  for (std::size_t c = 0; c < whole.channels.size(); ++c) {
    EXPECT_EQ(joined.channels[c].name, whole.channels[c].name);
    EXPECT_EQ(joined.channels[c].values, whole.channels[c].values) << whole.channels[c].name;
    bytes += whole.channels[c].values.size() * sizeof(double);
  }
  EXPECT_EQ(simulated_size(plan), bytes);
}

/// Ten minutes at rest, half an hour of a ramp, two hours at rest again; nothing but the coil to be seen.
std::vector<double> drift_in_a_ramp(const std::string& winding) {
  Plan plan;
  plan.instrument_model = "fiber_optic_gyro";
  plan.sample_rate = 1.0;
  plan.rig_kind = "thermal_chamber";
  plan.rig = defaults(find_rig(plan.rig_kind).options());
  for (const char* name : {"stability_sd", "draught_sd", "top_self_heating", "side_self_heating"})
    plan.rig.set_number(name, 0.0, Unit::parse("K"));
  plan.schedule = {{"cold", 600.0, 1, {{"chamber", {.kind = Motion::Kind::dwell, .value = 290.0}}}},
                   {"ramp", 1800.0, 1, {{"chamber", {.kind = Motion::Kind::ramp, .value = 1.0 / 60.0, .to = 320.0}}}},
                   {"warm", 7200.0, 1, {{"chamber", {.kind = Motion::Kind::dwell, .value = 320.0}}}}};
  plan.truth = defaults(truth_options(find_model(plan.instrument_model)));
  plan.truth.set_word("winding", winding);
  return simulate(plan, 1, {}).channels[0].values;
}

TEST(Simulate, HeatOnItsWayThroughTheCoilDriftsWithTheRampAndThenGoes) {
  const auto none = drift_in_a_ramp("none"), plain = drift_in_a_ramp("plain"),
             quadrupole = drift_in_a_ramp("quadrupole");
  ASSERT_EQ(plain.size(), 9600u);
  double largest = 0.0, largest_quadrupole = 0.0;
  for (std::size_t k = 0; k < plain.size(); ++k) {
    EXPECT_EQ(none[k], 0.0) << k;
    if (k < 500) {
      EXPECT_NEAR(plain[k], 0.0, 1e-15) << k;
    }
    largest = std::max(largest, std::abs(plain[k]));
    largest_quadrupole = std::max(largest_quadrupole, std::abs(quadrupole[k]));
  }
  EXPECT_GT(largest, si(1.0, "deg/h"));
  EXPECT_LT(largest_quadrupole, 0.1 * largest);
  // Two hours are twelve time constants of the slower side of the instrument: e^-8 of the drift is left at most.
  EXPECT_LT(std::abs(plain.back()), 1e-3 * largest);
}

/// An accelerometer that counts, on a head at 90 deg.
Plan counted() {
  Plan plan;
  plan.instrument_model = "pendulous_accelerometer";
  plan.sample_rate = 10.0;
  plan.rig_kind = "dividing_head";
  plan.rig = defaults(find_rig(plan.rig_kind).options());
  plan.schedule = {{"up", 60.0, 1, {{"head", {.kind = Motion::Kind::hold, .value = si(90.0, "deg")}}}}};
  plan.truth = defaults(truth_options(find_model(plan.instrument_model)));
  plan.truth.set_word("output", "count");
  plan.truth.set_number("pulse_scale_factor", si(20000.0, "pulse/s/g"), Unit::parse("pulse/s/g"));
  plan.truth.set_number("angle_random_walk", si(20.0, "ug/sqrt(Hz)"), Unit::parse("ug/sqrt(Hz)"));
  return plan;
}

TEST(Simulate, InstrumentsBesideFeelTheSameAndHaveNoiseOfTheirOwn) {
  const Plan alone = counted();
  Plan three = alone;
  three.beside = {{"S2", alone.instrument_model, alone.truth},
                  {"fog", "fiber_optic_gyro", defaults(truth_options(find_model("fiber_optic_gyro")))}};
  three.beside[0].truth.set_number("bias", si(100.0, "mg"), Unit::parse("mg"));
  const Recording one = simulate(alone, 1, {}), all = simulate(three, 1, {});
  ASSERT_EQ(all.channels.size(), one.channels.size() + 2);
  EXPECT_EQ(all.channels[0].name, "accelerometer");
  EXPECT_EQ(all.channels[0].values, one.channels[0].values);
  EXPECT_EQ(all.channels[1].name, "S2.accelerometer");
  EXPECT_EQ(all.channels[2].name, "fog.gyro");
  double first = 0.0, second = 0.0, differing = 0.0;
  for (std::size_t k = 100; k < 600; ++k) {
    first += all.channels[0].values[k];
    second += all.channels[1].values[k];
    differing += all.channels[1].values[k] - all.channels[0].values[k] == 200.0 ? 0.0 : 1.0;
  }
  // 0.1 g more of 20000 pulse/s/g over 50 s is 1e5 pulses; the noise of both is 4 pulses (20 ug sqrt(2/50) of 1e6).
  EXPECT_NEAR(second - first, 1e5, 20.0);
  EXPECT_GT(differing, 100.0);
  EXPECT_EQ(simulated_size(three), 600 * sizeof(double) * all.channels.size());
}

TEST(Simulate, AnInstrumentBesideMayBeMountedAtRightAngles) {
  Plan plan = counted();  // the head is at 90 deg: x up
  plan.beside = {{"y", plan.instrument_model, plan.truth}};
  plan.beside[0].mount_yaw = si(90.0, "deg");
  plan.schedule[0].axes["head"].value = si(30.0, "deg");
  const Recording both = simulate(plan, 1, {});
  // along the instrument's x and along what was its y: in the plane of the head's turn, sine and cosine of the angle
  double x = 0.0, y = 0.0;
  for (std::size_t k = 100; k < 600; ++k) {
    x += both.channels[0].values[k] / 1e6;
    y += both.channels[1].values[k] / 1e6;
  }
  EXPECT_NEAR(x, 0.5, 2e-3);
  EXPECT_NEAR(std::abs(y), std::sqrt(0.75), 2e-3);
}

TEST(Simulate, WhatIsWrongWithAnInstrumentBesideIsSaidWithItsName) {
  Plan plan = counted();
  plan.beside = {{"S2", plan.instrument_model, plan.truth}};
  plan.beside[0].truth.set_number("pulse_scale_factor", 0.0, Unit());
  plan.beside[0].truth.set_integer("oversampling", 7);
  try {
    simulate(plan, 1, {});
    FAIL();
  } catch (const Error& error) {
    ASSERT_EQ(error.problems.size(), 2u) << error.what();
    for (const std::string& problem : texts_of(error.problems))
      EXPECT_TRUE(problem.starts_with("[beside.S2.truth] ")) << problem;
  }
}

}  // namespace
}  // namespace tumble
