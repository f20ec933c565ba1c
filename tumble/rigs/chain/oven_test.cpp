// The oven of a dividing head: its first-order lag against the differential equation, its thermometer, its refusals.

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/rigs/rig.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::oven_test {
namespace {

using Kind = Motion::Kind;

const Rig& head() { return find_rig("dividing_head"); }

Settings options(const std::vector<Given>& given = {}) {
  Problems problems;
  auto settings = resolve(head().options(), given, "rig", problems);
  EXPECT_TRUE(problems.empty());
  return settings;
}

Motion hold(double celsius) { return {.kind = Kind::hold, .value = 273.15 + celsius}; }

/// From 20 to 40 degC at 5 K/min in 4 min, then 76 min there; a ramp down to 30 degC at 1 K/min, with 10 min more.
Schedule soak() {
  return {{"start", 60.0, 1, {{"temperature", hold(20.0)}}},
          {"heat", 4800.0, 1, {{"temperature", hold(40.0)}}},
          {"cool", 1200.0, 1, {{"temperature", {.kind = Kind::ramp, .value = 1.0 / 60.0, .to = 303.15}}}}};
}

RigRun run_of(Schedule schedule, const Settings& settings) {
  RigRun run;
  run.segments = std::move(schedule);
  run.options = settings;
  run.rate = 1.0;
  return run;
}

Felt felt(const Reference& reference, double time) {
  Felt out;
  reference.felt(time, 1.0, std::span(&out, 1));
  return out;
}

TEST(Oven, InstrumentFollowsTheAirWithAFirstOrderLag) {
  // T' = (air - T)/300 s by Runge-Kutta of second order at 0.05 s: error per step (0.05/300)^3 20 K/6, over 6060 s
  // 120000 steps of it, 2e-6 K. The soaked instrument is put on the air from 1 mK, which bounds the tolerance.
  const auto reference = head().reference(run_of(soak(), options({{"ideal", "true", "test", false}})));
  const auto air = [](double t) {
    if (t < 60.0) return 20.0;
    if (t < 300.0) return 20.0 + (t - 60.0) / 12.0;
    if (t < 4860.0) return 40.0;
    return std::max(30.0, 40.0 - (t - 4860.0) / 60.0);
  };
  const double step = 0.05;
  double T = 20.0, worst = 0.0;
  for (double t = 0.0; t < 6059.0; t += step) {
    const double half = T + 0.5 * step * (air(t) - T) / 300.0;
    T += step * (air(t + 0.5 * step) - half) / 300.0;
    const Felt now = felt(reference, t + step);
    worst = std::max(worst, std::abs(now.temperature - 273.15 - T));
    ASSERT_NEAR(now.temperature_rate, (air(t + step) - T) / 300.0, 1.1e-3 / 300.0 + 1e-8) << t;
  }
  EXPECT_LT(worst, 1.1e-3);
  EXPECT_EQ(felt(reference, 100.0).start_temperature, 293.15);
}

TEST(Oven, SettledWhenWarmAndSteadyWhenSoaked) {
  const auto reference = head().reference(run_of(soak(), options()));
  // after the ramp of 240 s the instrument is (20 K/240 s) 300 s (1 - exp(-0.8)) = 13.77 K behind
  const double behind = 25.0 * (1.0 - std::exp(-0.8));
  EXPECT_NEAR(reference.settled[1], 300.0 + 300.0 * std::log(behind / 0.05), 1e-6);
  EXPECT_EQ(reference.settled[2], 4860.0);
  const double soaked = 300.0 + 300.0 * std::log(behind / 1e-3);
  EXPECT_EQ(reference.steady_until(soaked - 1.0), soaked - 1.0);
  EXPECT_EQ(reference.steady_until(soaked + 1.0), 4860.0);
  EXPECT_EQ(felt(reference, soaked + 1.0).temperature, felt(reference, 4859.0).temperature);
}

TEST(Oven, RegulatesByItsThermometerWhichDoesNotShowItsOwnError) {
  RigRun run = run_of(soak(), options({{"thermometer_noise", "0 K", "test"}}));
  const auto errors = head().errors(run.options, run.site);
  run.errors = Matrix(errors.size(), 3);
  for (std::size_t e = 0; e < errors.size(); ++e)
    for (std::size_t s = 0; s < 3; ++s)
      run.errors(e, s) = errors[e].name == "thermometer offset"  ? 0.3
                         : errors[e].name == "thermometer scale" ? 0.01
                                                                 : 0;
  const auto reference = head().reference(run);
  // true: 40 + 0.3 + 0.01 40 degC
  EXPECT_NEAR(felt(reference, 4800.0).temperature, 273.15 + 40.7, 1e-9);
  const Sensor& thermometer = reference.sensors.back();
  EXPECT_EQ(thermometer.channel.name, "temperature");
  double reading = 0.0;
  thermometer.read(4800.0, 1.0, std::span(&reading, 1));
  EXPECT_NEAR(reading, 273.15 + 40.0, 1e-9);
}

TEST(Oven, RefusesWhatItCannotDo) {
  Schedule schedule{{"hot", 600.0, 1, {{"temperature", hold(100.0)}}},
                    {"short", 60.0, 1, {{"temperature", hold(20.0)}}},
                    {"fast", 600.0, 1, {{"temperature", {.kind = Kind::ramp, .value = 1.0, .to = 293.15}}}}};
  const auto problems = head().refusals(schedule, options());
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_TRUE(is_problem(problems[0], {.values = {"hot", "100", "-60", "90"}}));
  EXPECT_TRUE(is_problem(problems[1], {.values = {"short", "960", "60"}}));
  EXPECT_TRUE(is_problem(problems[2], {.values = {"fast", "60"}, .pattern = "oven_ramp_limit"}));
}

}  // namespace
}  // namespace tumble::oven_test
