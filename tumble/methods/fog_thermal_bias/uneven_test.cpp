#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"

namespace tumble::fog_thermal_bias_uneven_test {
namespace {

const Method& method() { return find_method("fog_thermal_bias"); }

/// The answer to the trial after its recording was changed.
Estimate after(std::uint64_t seed, const std::function<void(Recording&)>& change) {
  Trial trial = trial_of(method(), seed);
  change(trial.evidence.recordings[0]);
  return method().identify(trial.evidence, {});
}

Channel& channel_of(Recording& recording, const std::string& name) {
  return *std::ranges::find(recording.channels, name, &Channel::name);
}

TEST(FogUneven, ReadingsOfTheNextPowerUpAreLeftOut) {
  const Estimate sound = after(1, [](Recording&) {});
  const Estimate late = after(1, [](Recording& recording) {
    for (std::size_t k = 1; k < recording.marks.size(); ++k) recording.marks[k].begin += 0.15;
  });
  EXPECT_FALSE(has_finding(sound.findings, "power_ups_end_in_next"));
  EXPECT_TRUE(has_finding(late.findings, "power_ups_end_in_next"));
  const auto c1 = static_cast<std::size_t>(find_parameter(sound, "C1_0") - sound.parameters.data());
  EXPECT_NEAR(value(late, "C1_0"), value(sound, "C1_0"), standard_uncertainty(sound, c1));
}

/// Adds to the gyro what a function gives for the number of a power-up and the time [s] since its begin [deg/h].
std::function<void(Recording&)> shifted(const std::function<double(std::size_t run, double since)>& by) {
  return [by](Recording& recording) {
    Channel& gyro = channel_of(recording, "gyro");
    for (const tumble::Run& run : runs_of({recording}))
      for (std::size_t i = 0; i < gyro.values.size(); ++i)
        if (const double time = gyro.time(i); run.begin <= time && time < run.end)
          gyro.values[i] += si(by(static_cast<std::size_t>(run.number), time - run.begin), "deg/h");
  };
}

TEST(FogUneven, AStepAnOutlierAndADriftAreSaid) {
  const auto step =
      after(2, shifted([](std::size_t run, double since) { return run == 7 && since > 3000.0 ? 0.1 : 0.0; }));
  const auto outlier = after(2, shifted([](std::size_t run, double) { return run == 4 ? 1.0 : 0.0; }));
  const auto drift = after(2, shifted([](std::size_t run, double) { return 0.1 * static_cast<double>(run); }));
  EXPECT_TRUE(has_finding(step.findings, "power_up_steps"));
  EXPECT_TRUE(has_finding(outlier.findings, "power_up_differs"));
  EXPECT_TRUE(has_finding(drift.findings, "power_ups_drift"));
}

// An outlier of ten times the repeatability is said in most tests; the interval reaches down to that of the others in each.
TEST(FogUneven, TheRepeatabilityOfTheOthersIsInTheIntervalBesideAnOutlier) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Estimate sound = after(seed, [](Recording&) {});
    const Estimate outlying = after(seed, shifted([](std::size_t run, double) { return run == 4 ? 0.1 : 0.0; }));
    const double others = value(sound, "turn_on_repeatability");
    EXPECT_GT(value(outlying, "turn_on_repeatability"), 2.0 * others) << seed;
    EXPECT_LT(find_parameter(outlying, "turn_on_repeatability")->lower, others) << seed;
  }
}

/// Stamps of a channel that are later [s].
std::function<void(Recording&)> later(const std::vector<std::string>& channels, double by) {
  return [=](Recording& recording) {
    for (const std::string& name : channels) channel_of(recording, name).timeline.start += by;
  };
}

// Half a minute between the clocks of output and thermometers moves C by the delay times A: 7 sd.
TEST(FogUneven, AnOutputThatIsLateAgainstTheTemperatureIsSaid) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    EXPECT_FALSE(has_finding(after(seed, [](Recording&) {}).findings, "output_late_on_temperature"));
    const Estimate late = after(seed, later({"gyro"}, 25.0));
    ASSERT_TRUE(has_finding(late.findings, "output_late_on_temperature")) << seed;
    EXPECT_NEAR(value_of(late.findings, "output_late_on_temperature", "delay"), 25.0, 15.0);
  }
}

// The first readings of late thermometers are of the power-up before, at another temperature: with them the rate of change
// is wrong by far, and C is lost.
TEST(FogUneven, TemperaturesOfThePowerUpBeforeAreNotUsed) {
  const Estimate sound = after(1, [](Recording&) {});
  const Estimate late = after(1, later({"temperature_top", "temperature_side"}, 25.0));
  EXPECT_FALSE(has_finding(sound.findings, "power_ups_begin_in_last"));
  EXPECT_TRUE(has_finding(late.findings, "power_ups_begin_in_last"));
  // the delay itself remains, and takes 7 % of C with it; those readings took all
  EXPECT_NEAR(value(late, "C1_0") / value(sound, "C1_0"), 1.0, 0.1);
}

TEST(FogUneven, WhatGoesUpAndDownOrSettlesAlongTheRecordIsSaid) {
  const auto along = [](const std::function<double(double hours)>& by) {
    return [by](Recording& recording) {
      Channel& gyro = channel_of(recording, "gyro");
      for (std::size_t i = 0; i < gyro.values.size(); ++i) gyro.values[i] += si(by(gyro.time(i) / 3600.0), "deg/h");
    };
  };
  for (const std::uint64_t seed : {4u, 5u}) {
    const Estimate room = after(seed, along([](double hours) { return 0.05 * std::sin(2.3 * hours); }));
    ASSERT_TRUE(has_finding(room.findings, "output_goes_up_and_down")) << seed;
    EXPECT_NEAR(value_of(room.findings, "output_goes_up_and_down", "amplitude"), si(0.05, "deg/h"), si(0.02, "deg/h"));
    EXPECT_NEAR(value_of(room.findings, "output_goes_up_and_down", "period"), 3600.0 * 6.283 / 2.3, 800.0);
    const Estimate warm = after(seed, along([](double hours) { return 0.1 * std::exp(-hours / 1.5); }));
    EXPECT_TRUE(has_finding(warm.findings, "output_settles_along_record")) << seed;
  }
}

TEST(FogUneven, AThermometerInKelvinIsSaid) {
  const Estimate estimate = after(1, [](Recording& recording) {
    for (double& value : channel_of(recording, "temperature_top").values) value += 273.15;
  });
  EXPECT_TRUE(has_finding(estimate.findings, "temperature_of_no_chamber"));
}

}  // namespace
}  // namespace tumble::fog_thermal_bias_uneven_test
