// What each rig does by itself: the geometry written on its page.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/earth/earth.hpp"
#include "tumble/math/rotation.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/rigs/testing/bench.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using Kind = Motion::Kind;

/// What is felt after everything has settled in a single segment.
Felt settled(const Rig& rig, std::map<std::string, Motion> axes, const Settings& options, double time = 90.0) {
  return felt(rig.reference(run_of({{"s", 100.0, 1, std::move(axes)}}, options)), time, 1.0, 1).front();
}

Motion held(double degrees) { return {.kind = Kind::hold, .value = degrees * degree}; }
Motion turning(double degrees) { return {.kind = Kind::rate, .value = degrees * degree}; }

void expect_near(Vector3 a, Vector3 b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(ThermalChamber, InstrumentLiesStillOnTheEarth) {
  const Rig& rig = find_rig("thermal_chamber");
  const auto felt = settled(rig, {{"chamber", {.kind = Kind::dwell, .value = 300.0}}}, with(rig, {}));
  EXPECT_EQ(felt.specific_force.x, 0.0);
  EXPECT_EQ(felt.specific_force.y, 0.0);
  EXPECT_EQ(felt.specific_force.z, *site.gravity);
  EXPECT_EQ(felt.rate.x, 0.0);
  EXPECT_EQ(felt.rate.y, earth_rate_in_level(site).y);
  EXPECT_EQ(felt.rate.z, earth_rate_in_level(site).z);
}

TEST(Rigs, NothingIsColderThanAbsoluteZero) {
  for (const Rig* rig : rig_catalogue()) {
    const char* option = std::string(rig->name) == "thermal_chamber" ? "lowest" : "temperature";
    Problems problems;
    resolve(rig->options(), {{option, "-300 degC", "test"}}, "rig", problems);
    ASSERT_EQ(problems.size(), 1u) << rig->name;
    EXPECT_TRUE(is_problem(problems[0], {.values = {"-300 degC"}, .part = "above -273.15 degC", .key = option}));
  }
}

TEST(DividingHead, TurnsGravityThroughXAndY) {
  const Rig& rig = find_rig("dividing_head");
  for (const double angle : {0.0, 30.0, 90.0, 225.0}) {
    const auto at = settled(rig, {{"head", held(angle)}}, defaults(rig.options()));
    expect_near(at.specific_force, {9.7966 * std::sin(angle * degree), 9.7966 * std::cos(angle * degree), 0.0}, 1e-12);
  }
  // the axis points north: z sees the Earth's horizontal rate, y at 0 the vertical one
  const auto at = settled(rig, {{"head", held(0.0)}}, defaults(rig.options()));
  expect_near(at.rate, {0.0, earth_rate * std::sin(34.0 * degree), earth_rate * std::cos(34.0 * degree)}, 1e-18);
}

// Axis parallel to the Earth's: no Earth rate across it, f = g (cos phi sin th, cos phi cos th, sin phi) but for the
// choice of zero.
TEST(RateTable, PolarAxisTumble) {
  const Rig& rig = find_rig("rate_table");
  const auto options = with(rig, {{"axis_elevation", "34 deg", "test"}});
  for (const double angle : {0.0, 40.0, 200.0}) {
    const auto at = settled(rig, {{"table", held(angle)}}, options);
    expect_near(at.rate, {0.0, 0.0, earth_rate}, 1e-18);
    EXPECT_NEAR(at.specific_force.z, 9.7966 * std::sin(34.0 * degree), 1e-12);
    EXPECT_NEAR(at.specific_force.x, -9.7966 * std::cos(34.0 * degree) * std::sin(angle * degree), 1e-12);
    EXPECT_NEAR(at.specific_force.y, -9.7966 * std::cos(34.0 * degree) * std::cos(angle * degree), 1e-12);
  }
}

TEST(RateTable, UpwardAxisAddsItsRateToTheVerticalEarthRate) {
  const Rig& rig = find_rig("rate_table");
  const auto at = settled(rig, {{"table", turning(-20.0)}}, defaults(rig.options()));
  EXPECT_NEAR(at.rate.z, -20.0 * degree + earth_rate * std::sin(34.0 * degree), 1e-16);
  EXPECT_NEAR(std::hypot(at.rate.x, at.rate.y), earth_rate * std::cos(34.0 * degree), 1e-17);
}

TEST(TwoAxisTable, AttitudeIsInnerAfterOuter) {
  const Rig& rig = find_rig("two_axis_table");
  const auto at = settled(rig, {{"outer", held(90.0)}, {"inner", held(30.0)}}, defaults(rig.options()));
  // outer 90 deg about east: the table's y is up, its z south
  const double s = 0.5, c = std::sqrt(0.75), g = 9.7966;
  expect_near(at.specific_force, {g * s, g * c, 0.0}, 1e-12);
  const double up = earth_rate * std::sin(34.0 * degree), north = earth_rate * std::cos(34.0 * degree);
  expect_near(at.rate, {s * up, c * up, -north}, 1e-18);
}

TEST(ThreeAxisTable, YawPitchRoll) {
  const Rig& rig = find_rig("three_axis_table");
  const auto at =
      settled(rig, {{"outer", held(20.0)}, {"middle", held(-40.0)}, {"inner", held(70.0)}}, defaults(rig.options()));
  const Rotation r = about_x(70.0 * degree) * about_y(-40.0 * degree) * about_z(20.0 * degree);
  expect_near(at.specific_force, r * Vector3{0.0, 0.0, 9.7966}, 1e-12);
  expect_near(at.rate, r * earth_rate_in_level(site), 1e-18);
  const auto mounted = settled(find_rig("rate_table"),
                               {{"mount_yaw", held(20.0)}, {"mount_pitch", held(-40.0)}, {"mount_roll", held(70.0)}},
                               defaults(find_rig("rate_table").options()));
  expect_near(mounted.specific_force, at.specific_force, 1e-12);
}

TEST(Centrifuge, CentripetalForceAndTheRateNeededForIt) {
  const Rig& rig = find_rig("centrifuge");
  // R = 1 m: 1, 10, 20 g at 179.43, 567.39, 802.41 deg/s (rounded to 0.005 deg/s: 6e-5 of 1 g, 2e-5, 1.3e-5)
  for (const auto& [g, rate] : {std::pair{1.0, 179.43}, {10.0, 567.39}, {20.0, 802.41}}) {
    const auto at = settled(rig, {{"arm", turning(rate)}}, defaults(rig.options()));
    EXPECT_NEAR(at.specific_force.x / -standard_gravity, g, 6e-4);
    const double up = rate * degree + earth_rate * std::sin(34.0 * degree);
    EXPECT_NEAR(at.specific_force.x, -up * up, 1e-3 * earth_rate + 1e-7);
    EXPECT_NEAR(at.specific_force.z, 9.7966, 2e-3);  // Coriolis: 2 w_e cos(latitude) w R = 1.7e-3 m/s^2
  }
  // while it speeds up the instrument is pushed along its motion: R times the angular acceleration
  const auto at = settled(rig, {{"arm", turning(1000.0)}}, defaults(rig.options()), 5.0);
  EXPECT_NEAR(at.specific_force.y, 30.0 * degree, 1e-3);
}

// Counter-rotating table, (1.1) to (1.3) of the DTG centrifuge test: f_X = -a cos(w_s t - psi_0),
// f_Y = -a sin(w_s t - psi_0), net rate 40 deg/s.
TEST(CounterRotatingCentrifuge, InstrumentSeesTheArmTurnBackwards) {
  const Rig& rig = find_rig("counter_rotating_centrifuge");
  const auto options = with(rig, {{"radius", "2.5 m", "test"}});
  const Schedule schedule{{"spin", 100.0, 1, {{"arm", turning(254.0)}, {"table", turning(-214.0)}}}};
  const auto reference = rig.reference(run_of(schedule, options));
  EXPECT_NEAR(reference.settled[0], 254.0 / 30.0, 1e-9);
  const auto samples = felt(reference, 50.0, 0.01, 1000);
  std::vector<double> angle(samples.size());
  const auto table = std::find_if(reference.sensors.begin(), reference.sensors.end(),
                                  [](const Sensor& sensor) { return sensor.channel.name == "table_angle"; });
  ASSERT_NE(table, reference.sensors.end());
  table->read(50.0, 0.01, angle);
  const double up = 254.0 * degree + earth_rate * std::sin(34.0 * degree);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // the encoder counts to 1e-4 deg and has 0.1 arcsec of noise; the Earth's other component adds 2 w w_e R < 1e-3
    EXPECT_NEAR(samples[i].specific_force.x, -2.5 * up * up * std::cos(angle[i]), 1.5e-4);
    EXPECT_NEAR(samples[i].specific_force.y, 2.5 * up * up * std::sin(angle[i]), 1.5e-4);
    EXPECT_NEAR(samples[i].rate.z, 40.0 * degree + earth_rate * std::sin(34.0 * degree), 1e-12);
    EXPECT_NEAR(std::hypot(samples[i].rate.x, samples[i].rate.y), earth_rate * std::cos(34.0 * degree), 1e-12);
  }
}

// Table of worked numbers: R = 2.5 m, standard gravity.
TEST(CounterRotatingCentrifuge, WorkedAccelerations) {
  const Rig& rig = find_rig("counter_rotating_centrifuge");
  const auto options = with(rig, {{"radius", "2.5 m", "test"}});
  for (const auto& [rate, g] :
       {std::pair{114.0, 1.009}, {160.0, 1.988}, {254.0, 5.010}, {359.0, 10.008}, {508.0, 20.040}}) {
    RigRun run = run_of({{"s", 100.0, 1, {{"arm", turning(rate)}, {"table", turning(40.0 - rate)}}}}, options);
    run.site.reset();
    const auto at = felt(rig.reference(run), 90.0, 1.0, 1).front();
    EXPECT_NEAR(std::hypot(at.specific_force.x, at.specific_force.y) / standard_gravity, g, 5e-4);
    EXPECT_NEAR(at.rate.z, 40.0 * degree, 1e-12);
  }
}

// The table's axis leaning 10 arcsec against the arm's at 340 deg/s: a true rate of 59.341 deg/h at the table's rate.
TEST(CounterRotatingCentrifuge, TiltOfTheTableAxisIsATrueRateAtTheTablesRate) {
  const Rig& rig = find_rig("counter_rotating_centrifuge");
  const auto options = defaults(rig.options());
  const Schedule schedule{{"spin", 100.0, 1, {{"arm", turning(340.0)}, {"table", turning(-300.0)}}}};
  RigRun run = run_of(schedule, options);
  run.site.reset();
  const auto errors = rig.errors(options, run.site);
  run.errors = Matrix(errors.size(), 1);
  for (std::size_t e = 0; e < errors.size(); ++e)
    if (errors[e].name == "tilt of the table axis about the arm") run.errors(e, 0) = si(10.0, "arcsec");
  // 300 deg/s: 1.2 s are one turn of the table
  const auto samples = felt(rig.reference(run), 50.0, 0.01, 120);
  double c = 0.0, s = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / 120.0;
    c += samples[i].rate.x * std::cos(angle) / 60.0;
    s += samples[i].rate.x * std::sin(angle) / 60.0;
    largest = std::max(largest, std::hypot(samples[i].rate.x, samples[i].rate.y));
  }
  EXPECT_NEAR(std::hypot(c, s), si(59.341, "deg/h"), si(0.001, "deg/h"));
  EXPECT_NEAR(largest, si(59.341, "deg/h"), si(0.001, "deg/h"));
}

TEST(Centrifuge, RadiusGrowsWithTheSquareOfTheRate) {
  const Rig& rig = find_rig("centrifuge");
  const auto options = with(rig, {{"stretch", "3 um/(rad/s)^2", "test"}});
  const double w = 500.0 * degree;
  RigRun run = run_of({{"s", 100.0, 1, {{"arm", turning(500.0)}}}}, options);
  run.site.reset();
  const auto at = felt(rig.reference(run), 90.0, 1.0, 1).front();
  EXPECT_NEAR(at.specific_force.x, -w * w * (1.0 + 3e-6 * w * w), 1e-11 * w * w);
}

std::string refused(const Rig& rig, const Schedule& schedule, const std::vector<Given>& given = {}) {
  std::string all;
  for (const auto& problem : rig.refusals(schedule, with(rig, given))) all += problem.text() + "\n";
  return all;
}

TEST(Tables, WhatAScheduleAsksBeyondTheLimitsIsRefusedAllAtOnce) {
  const Rig& rig = find_rig("two_axis_table");
  const auto all =
      refused(rig,
              {{"fast", 60.0, 1, {{"inner", turning(900.0)}, {"outer", held(120.0)}}},
               {"short", 0.1, 1, {{"outer", held(0.0)}}},
               {"shaken", 60.0, 1, {{"inner", {.kind = Kind::sine, .amplitude = 1.0, .frequency = 20.0}}}}},
              {{"outer_highest", "90 deg", "test"}, {"outer_lowest", "-90 deg", "test"}});
  for (const char* part :
       {"segment 'fast': inner at 900 deg/s is above its max_rate of 500 deg/s",
        "segment 'fast': outer would reach 120 deg, beyond its stop at 90 deg", "segment 'short': outer needs",
        "segment 'shaken': inner would oscillate", "above its max_acceleration of 500 deg/s^2"})
    EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
}

Motion sine(double g, double frequency) {
  return {.kind = Kind::sine, .amplitude = g * standard_gravity, .frequency = frequency};
}

Motion random_vibration(double low, double high, double g2_per_hertz) {
  const double density = g2_per_hertz * standard_gravity * standard_gravity;
  return {.kind = Kind::random, .psd_frequency = {low, high}, .psd = {density, density}};
}

TEST(Shaker, SineAlongXOnTopOfGravity) {
  const Rig& rig = find_rig("shaker");
  const auto reference = rig.reference(run_of({{"still", 10.0, 1, {}}, {"sine", 10.0, 1, {{"shake", sine(3.0, 80.0)}}}},
                                              with(rig, {{"reference_noise", "0 mg", "test"}})));
  EXPECT_EQ(reference.settled[0], 0.0);
  EXPECT_NEAR(reference.settled[1], 10.0 + 2.0 / 80.0, 1e-12);
  EXPECT_EQ(reference.steady_until(1.0), 10.0);
  EXPECT_EQ(reference.steady_until(11.0), 11.0);
  const double step = 1.0 / 3777.0;
  const auto samples = felt(reference, 11.0, step, 5000);
  std::vector<double> readings(samples.size());
  reference.sensors.front().read(11.0, step, readings);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double a =
        3.0 * standard_gravity * std::sin(2.0 * std::numbers::pi * 80.0 * (1.0 + static_cast<double>(i) * step));
    ASSERT_NEAR(samples[i].specific_force.x, 9.7966 + a, 1e-9);
    ASSERT_NEAR(samples[i].specific_force.y, 0.0, 1e-12);
    ASSERT_NEAR(readings[i], a, 1e-9);
  }
}

// Means over 5 ms of a sine of 80 Hz are its middle times sinc(0.4); of random vibration up to 2 kHz, sums of 400
// steps: to 1e-3 g of 2.8 g, and without the gravity that the instrument feels.
TEST(Shaker, ReferenceAsMeanOverTheSamples) {
  const Rig& rig = find_rig("shaker");
  const auto options = with(rig, {{"reference_noise", "0 mg", "test"}, {"reference_output", "mean", "test"}});
  const double window = 0.005;
  std::vector<double> readings(500);
  rig.reference(run_of({{"sine", 10.0, 1, {{"shake", sine(3.0, 80.0)}}}}, options))
      .sensors[0]
      .read(1.0, window, readings);
  const double x = std::numbers::pi * 0.4, amplitude = 3.0 * standard_gravity * std::sin(x) / x;
  for (std::size_t i = 0; i < readings.size(); ++i)
    ASSERT_NEAR(readings[i],
                amplitude * std::sin(2.0 * std::numbers::pi * 80.0 * (1.0 + window * static_cast<double>(i))),
                1e-4 * amplitude);
  const auto reference =
      rig.reference(run_of({{"random", 10.0, 1, {{"shake", random_vibration(20.0, 2000.0, 0.1)}}}}, options));
  reference.sensors[0].read(1.0, window, readings);
  constexpr std::size_t steps = 400;
  const auto samples = felt(reference, 1.0 - 0.5 * window + 0.5 * window / steps, window / steps, 500 * steps);
  double squares = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    double mean = -9.7966;
    for (std::size_t k = 0; k < steps; ++k) mean += samples[i * steps + k].specific_force.x / steps;
    ASSERT_NEAR(readings[i], mean, 0.03) << i;
    squares += readings[i] * readings[i] / 500.0;
  }
  EXPECT_NEAR(std::sqrt(squares) / standard_gravity, 2.8143, 4.0 * 2.8143 / std::sqrt(1000.0));
}

// Remounted between segments: the shake, and gravity, move to another axis of the instrument.
TEST(Shaker, ShakesTheAxisThatIsMountedAlongIt) {
  const Rig& rig = find_rig("shaker");
  const auto reference = rig.reference(run_of({{"x", 1.0, 1, {{"shake", sine(3.0, 80.0)}}},
                                               {"z", 1.0, 1, {{"shake", sine(3.0, 80.0)}, {"mount_pitch", held(90.0)}}},
                                               {"still", 1.0, 1, {}}},
                                              defaults(rig.options())));
  const auto samples = felt(reference, 1.0 / 640.0, 1.0 / 320.0, 960);  // the quarters of 80 Hz: +-sqrt(1/2)
  const double a = 3.0 * standard_gravity * std::sqrt(0.5);
  for (const auto& [i, vibration] :
       {std::pair<std::size_t, double>{240, a}, {242, -a}, {560, a}, {562, -a}, {700, 0.0}}) {
    const double along = 9.7966 + vibration;
    expect_near(samples[i].specific_force, i < 320 ? Vector3{along, 0.0, 0.0} : Vector3{0.0, 0.0, along}, 1e-9);
  }
}

// 0.1 g^2/Hz from 20 to 2000 Hz are sqrt(198) = 14.0712 g. T = 100 s of a band of 1980 Hz: the variance of the variance
// estimate is S^2 B/T, relative sd of the rms 1/(2 sqrt(B T)) = 0.0011; 4 sigma.
TEST(Shaker, RandomVibrationHasItsRms) {
  const Rig& rig = find_rig("shaker");
  const auto reference = rig.reference(run_of({{"still", 10.0, 1, {}},
                                               {"random", 100.0, 1, {{"shake", random_vibration(20.0, 2000.0, 0.1)}}},
                                               {"still", 10.0, 1, {}}},
                                              defaults(rig.options()), 10000.0));
  const auto samples = felt(reference, 10.00005, 1e-4, 1000000);
  double sum = 0.0;
  for (const auto& sample : samples) sum += std::pow((sample.specific_force.x - 9.7966) / standard_gravity, 2);
  EXPECT_NEAR(std::sqrt(sum / 1e6), 14.0712, 4.0 * 0.0011 * 14.0712);
  EXPECT_EQ(felt(reference, 110.5, 1.0, 1)[0].specific_force.x, felt(reference, 5.0, 1.0, 1)[0].specific_force.x);
}

TEST(Shaker, WhatItCannotDoIsRefusedAllAtOnce) {
  const Rig& rig = find_rig("shaker");
  const auto all = refused(rig, {{"strong", 10.0, 1, {{"shake", sine(150.0, 100.0)}}},
                                 {"wide", 10.0, 1, {{"shake", sine(10.0, 6.0)}}},
                                 {"slow", 10.0, 1, {{"shake", sine(0.1, 2.0)}}},
                                 {"short", 0.2, 1, {{"shake", sine(1.0, 8.0)}}},
                                 {"loud", 10.0, 1, {{"shake", random_vibration(20.0, 2000.0, 1.0)}}},
                                 {"broad", 10.0, 1, {{"shake", random_vibration(1.0, 5000.0, 0.001)}}},
                                 {"empty", 10.0, 1, {{"shake", {.kind = Kind::random}}}},
                                 {"pushed", 10.0, 1, {{"shake", {.kind = Kind::hold, .value = 1.0}}}}});
  for (const char* part :
       {"segment 'strong': an acceleration of 150 g", "segment 'wide': a way of", "segment 'wide': a velocity of",
        "segment 'slow': 2 Hz is not within", "segment 'short': two periods",
        "segment 'loud': a standard deviation of 44.5 g", "segment 'broad': 1 to 5000 Hz are not within",
        "segment 'empty': shake needs two or more frequencies", "segment 'pushed': shake cannot hold"})
    EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
}

// The rates of a move, tremor included, turn the instrument from one rest to the next exactly: what is felt in the two
// rests is the same gravity and Earth rate. 1e5 steps of the middle rate: h^2/12 |w x w'| < 1e-8 rad in all.
TEST(ByHand, RatesOfAMoveAddUpToTheNewPose) {
  const Rig& rig = find_rig("by_hand");
  const Schedule schedule{{"rest 1", 10.0, 1, {{"mount_roll", held(10.0)}}},
                          {"rest 2", 10.0, 1, {{"mount_roll", held(-150.0)}, {"mount_pitch", held(60.0)}}},
                          {"rest 3", 10.0, 1, {}},
                          {"rest 4", 10.0, 1, {{"mount_roll", held(30.0)}}}};
  const auto reference = rig.reference(run_of(schedule, defaults(rig.options())));
  EXPECT_EQ(reference.settled, (std::vector<double>{0.0, 12.0, 20.0, 32.0}));
  EXPECT_EQ(reference.steady_until(5.0), 10.0);
  EXPECT_EQ(reference.steady_until(10.5), 10.5);
  EXPECT_EQ(reference.steady_until(15.0), 30.0);
  for (const double begin : {10.0, 30.0}) {
    const double h = 2e-5;
    const auto samples = felt(reference, begin + 0.5 * h, h, 100000);
    Rotation turned;
    double most = 0.0;
    for (const auto& sample : samples) {
      const double w = norm(sample.rate);
      turned = about((1.0 / w) * sample.rate, w * h) * turned;
      most = std::max(most, w);
    }
    EXPECT_GT(most, 1.0);
    const auto before = felt(reference, begin - 1.0, 1.0, 1)[0], after = felt(reference, begin + 2.0, 1.0, 1)[0];
    // the Earth turned on by 1.5e-4 rad during the move: gravity did not keep its place in inertial space
    const Rotation earth = about((1.0 / earth_rate) * before.rate, -earth_rate * 2.0);
    expect_near(turned * earth * before.specific_force, after.specific_force, 1e-6);
    expect_near(turned * before.rate, after.rate, 1e-11);
  }
}

// Away from the point about which the hand turns, the force is that of the trajectory: differentiated twice.
TEST(ByHand, LeverArmFeelsTheMove) {
  const Rig& rig = find_rig("by_hand");
  const Schedule schedule{{"rest 1", 10.0, 1, {}}, {"rest 2", 10.0, 1, {{"mount_roll", held(90.0)}}}};
  RigRun run = run_of(schedule, with(rig, {{"tremor_sd", "0 deg", "test"}, {"lever_z", "200 mm", "test"}}));
  run.site.reset();
  const auto reference = rig.reference(run);
  const auto angle = [](double time) {
    const double s = 0.5 * (time - 10.0);
    return 0.5 * std::numbers::pi * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  };
  for (const double time : {10.4, 11.0, 11.7}) {
    const double h = 1e-4, a = angle(time), rate = (angle(time + h) - angle(time - h)) / (2.0 * h),
                 acceleration = (angle(time + h) - 2.0 * a + angle(time - h)) / (h * h);
    const auto at = felt(reference, time, 1.0, 1)[0];
    EXPECT_NEAR(at.rate.x, rate, 1e-7);
    EXPECT_NEAR(at.specific_force.y, standard_gravity * std::sin(a) - 0.2 * acceleration, 1e-6);
    EXPECT_NEAR(at.specific_force.z, standard_gravity * std::cos(a) - 0.2 * rate * rate, 1e-6);
  }
}

TEST(ByHand, RestTooShortForTheMoveIsRefused) {
  const Rig& rig = find_rig("by_hand");
  const auto all =
      refused(rig, {{"first", 1.0, 1, {}}, {"short", 1.0, 1, {{"mount_roll", held(90.0)}}}, {"same", 1.0, 1, {}}});
  EXPECT_NE(all.find("segment 'short' lasts 1 s"), std::string::npos) << all;
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 1) << all;
}

}  // namespace
}  // namespace tumble
