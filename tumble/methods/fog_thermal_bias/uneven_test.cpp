#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

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

TEST(FogUneven, AThermometerInKelvinIsSaid) {
  const Estimate estimate = after(1, [](Recording& recording) {
    for (double& value : channel_of(recording, "temperature_top").values) value += 273.15;
  });
  EXPECT_TRUE(has_finding(estimate.findings, "temperature_of_no_chamber"));
}

}  // namespace
}  // namespace tumble::fog_thermal_bias_uneven_test
