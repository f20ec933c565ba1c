// What changes with time within the segments of a test: steps, waves, values that were cut out, steps of a converter.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"

namespace tumble::terms_in_time_test {
namespace {

Channel& channel(Trial& trial, const std::string& name) {
  return *std::ranges::find(trial.evidence.recordings.front().channels, name, &Channel::name);
}

Estimate identified(const char* method, const Trial& trial) { return find_method(method).identify(trial.evidence, {}); }

std::size_t index_in(const Estimate& estimate, const std::string& name) {
  return static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data());
}

/// (estimate - truth)/sd of the parameter that is farthest off.
double farthest(const Estimate& estimate, const Trial& trial) {
  double most = 0.0;
  for (const auto& [name, truth] : trial.truth) {
    const std::size_t i = index_in(estimate, name);
    most = std::max(most, std::abs(estimate.parameters[i].value - truth) / standard_uncertainty(estimate, i));
  }
  return most;
}

/// Adds to the counts of the accelerometer what the function gives for the time [s].
template <class Added>
void add(Trial& trial, const Added& added) {
  Channel& output = channel(trial, "accelerometer");
  for (std::size_t i = 0; i < output.values.size(); ++i)
    output.values[i] = std::round(output.values[i] + added(output.time(i)));
}

TEST(TermsInTime, AStepInsideASegmentIsNamedByTheSegmentAndInTheUncertainty) {
  Trial trial = trial_of(find_method("accelerometer_tumble"), 1);
  const Estimate sound = identified("accelerometer_tumble", trial);
  add(trial, [](double time) { return time < 1045.0 ? 0.0 : 20.0; });
  const Estimate estimate = identified("accelerometer_tumble", trial);
  const auto finding = std::ranges::find(estimate.findings, "output_steps", &Finding::code);
  ASSERT_NE(finding, estimate.findings.end());
  EXPECT_EQ(std::get<std::string>(finding->values.front().value), trial.evidence.plan.schedule[10].label);
  EXPECT_LT(farthest(estimate, trial), 3.0);
  EXPECT_TRUE(std::ranges::any_of(
      estimate.budget, [](const Contribution& line) { return line.source == "term that the model may lack"; }));
  EXPECT_TRUE(std::ranges::none_of(sound.findings, [](const Finding& one) { return one.code == "output_steps"; }));
}

TEST(TermsInTime, AWaveIsNamedWithItsPeriod) {
  Trial trial = trial_of(find_method("accelerometer_tumble"), 2);
  const auto has_waves = [&] {
    const Estimate estimate = identified("accelerometer_tumble", trial);
    return std::ranges::find(estimate.findings, "output_waves", &Finding::code) != estimate.findings.end();
  };
  EXPECT_FALSE(has_waves());
  add(trial, [](double time) { return 5.0 * std::sin(2.0 * std::numbers::pi * time / 450.0); });
  const Estimate estimate = identified("accelerometer_tumble", trial);
  const auto finding = std::ranges::find(estimate.findings, "output_waves", &Finding::code);
  ASSERT_NE(finding, estimate.findings.end());
  EXPECT_NEAR(std::get<double>(finding->values.front().value), 450.0, 45.0);  // half a wave over the test is 5 % of it
  EXPECT_LT(farthest(estimate, trial), 3.5);
}

TEST(TermsInTime, ASegmentWhoseLargestValuesAreCutOutIsNotUsed) {
  Trial trial = trial_of(find_method("accelerometer_centrifuge"), 1);
  std::vector<double>& values = channel(trial, "accelerometer").values;
  std::vector<double> sorted = values;
  std::ranges::sort(sorted);
  const double limit = sorted[sorted.size() * 9 / 10];  // in the middle of a level
  for (double& value : values)
    if (value > limit) value = std::nan("");
  const Estimate estimate = identified("accelerometer_centrifuge", trial);
  EXPECT_TRUE(std::ranges::any_of(estimate.findings, [](const Finding& finding) {
    return finding.code == "segment_not_used" && std::get<Phrase>(finding.values[1].value).key == "values_cut_out";
  }));
  EXPECT_LT(farthest(estimate, trial), 3.5);
}

TEST(TermsInTime, ASampleLostHereAndThereCostsNoSegment) {
  Trial trial = trial_of(find_method("accelerometer_centrifuge"), 1);
  std::vector<double>& values = channel(trial, "accelerometer").values;
  for (std::size_t i = 3; i < values.size(); i += 17) values[i] = std::nan("");
  for (const Finding& finding : identified("accelerometer_centrifuge", trial).findings)
    EXPECT_NE(finding.code, "segment_not_used");
}

// The rate of the Earth and the bias stay within one step at all rests: nothing but the step says how far the bias is off.
TEST(TermsInTime, AStepThatNoRestCrossesIsInTheUncertaintyOfTheBias) {
  Trial trial = trial_of(find_method("imu_turntable"), 3);
  constexpr double step = 2.8e-4;  // [rad/s]
  for (double& value : channel(trial, "gyro_x").values) value = step * std::round(value / step);
  const Estimate estimate = identified("imu_turntable", trial);
  EXPECT_LT(farthest(estimate, trial), 3.5);
  EXPECT_GT(standard_uncertainty(estimate, index_in(estimate, "gyro_x_bias")), 0.08 * step);
}

}  // namespace
}  // namespace tumble::terms_in_time_test
