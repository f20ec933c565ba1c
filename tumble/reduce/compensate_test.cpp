#include "tumble/reduce/compensate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/math/random.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/reduce/output_model.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double g = 9.80665;

const std::vector<Term>& terms() {
  static const std::vector<Term> all{{"bias", "K_0", "ug", "", 1.0},
                                     {"second_order", "K_2", "ug/g^2", "", Input::f_x * Input::f_x},
                                     {"cross", "K_ip", "ug/g^2", "", Input::f_x * Input::f_y}};
  return all;
}

/// K = 1.3 mA/g, 2 mg, -0.3 mg/g^2, 0.8 mg/g^2, correlated uncertainties; calibrated in +-1 g.
Estimate result() {
  Estimate estimate;
  const auto add = [&](const char* name, const char* unit, double value) {
    estimate.parameters.push_back({name, name, Unit::parse(unit), si(value, unit), ""});
  };
  add("scale_factor", "mA/g", 1.3);
  add("bias", "ug", 2000.0);
  add("second_order", "ug/g^2", -300.0);
  add("cross", "ug/g^2", 800.0);
  Matrix shifts(4, 4);
  shifts(0, 0) = si(1e-4, "mA/g");
  shifts(1, 0) = si(-30.0, "ug"), shifts(1, 1) = si(50.0, "ug");
  shifts(2, 1) = si(10.0, "ug/g^2"), shifts(2, 2) = si(20.0, "ug/g^2");
  shifts(3, 2) = si(-15.0, "ug/g^2"), shifts(3, 3) = si(25.0, "ug/g^2");
  settle(estimate, {from_shifts("fit", shifts)});
  OutputModel model = output_model(estimate, "accelerometer", Input::specific_force_x, "g",
                                   {terms(), {1.0, 0.0, -g * g}, {1.0, g * g, g * g}});
  set_scale(estimate, "scale_factor", model);
  estimate.models = {model};
  return estimate;
}

/// Output of an instrument with these parameters that feels (a_x, a_y).
double shown(const std::vector<double>& p, double x, double y) {
  return p[0] * (x + p[1] + p[2] * x * x + p[3] * x * y);
}

std::vector<double> values_of(const Estimate& estimate) {
  std::vector<double> values;
  for (const auto& parameter : estimate.parameters) values.push_back(parameter.value);
  return values;
}

/// The recording of a_x and, if asked, a_y.
Recording recording_of(const std::vector<double>& p, const std::vector<double>& x, const std::vector<double>& y,
                       bool with_y) {
  Recording recording;
  Channel output{"accelerometer", QuantityKind::other, Unit::parse("mA"), {0.0, 100.0, nullptr}, {}};
  Channel across{"specific_force_y", QuantityKind::specific_force, Unit::parse("g"), output.timeline, y};
  for (std::size_t i = 0; i < x.size(); ++i) output.values.push_back(shown(p, x[i], y[i]));
  recording.channels = {output};
  if (with_y) recording.channels.push_back(across);
  return recording;
}

/// Mean of ((u_hat - u)/sd)^2 over instruments drawn from the result's covariance, at (a_x, a_y) drawn each time.
double mean_square(bool with_y) {
  const Estimate estimate = result();
  const RandomStream random(with_y ? 5 : 6);
  const std::size_t draws = 2000;
  double sum = 0.0;
  for (std::size_t n = 0; n < draws; ++n) {
    auto p = values_of(estimate);
    const auto& factor = estimate.budget[0].factor;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 4; ++k) p[i] += factor(i, k) * random.normal(8 * n + k);
    // a_x a_y = +-g^2/sqrt(3) has the mean square g^4/3 of an even spread over its calibrated range
    const double x = (random.normal(8 * n + 5) > 0.0 ? 1.0 : -1.0) * g / std::sqrt(3.0);
    const double y = random.normal(8 * n + 6) > 0.0 ? g : -g;
    const auto done = compensate(estimate, recording_of(p, {x}, {y}, with_y), nullptr);
    const double z = (done.recording.channels[0].values[0] - x) /
                     find_channel(done.recording, "accelerometer.compensation_sd")->values[0];
    sum += z * z;
  }
  return sum / static_cast<double>(draws);
}

TEST(Compensate, TheInputComesBackToRounding) {
  const std::vector<double> x{-g, -0.3 * g, 1e-6, 0.2, g}, y{g, 0.0, -g, 3.0, -5.0};
  const Estimate estimate = result();
  const auto done = compensate(estimate, recording_of(values_of(estimate), x, y, true), nullptr);
  // 1e-12 of what is measured: at 1e-6 m/s^2 this is the bias, 0.02 m/s^2
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(done.recording.channels[0].values[i], x[i], 1e-12 * (std::abs(x[i]) + 0.02)) << i;
  EXPECT_TRUE(done.findings.empty());
  EXPECT_EQ(done.recording.channels[0].unit.text(), "g");
  EXPECT_EQ(done.recording.channels[0].kind, QuantityKind::specific_force);
  ASSERT_EQ(done.tables.size(), 2u);
  EXPECT_EQ(done.tables[1].rows.size(), 3u);
}

// A mean of 2000 squares has the sd sqrt(2/2000); four of them.
TEST(Compensate, TheUncertaintyIsThatOfTheParameters) {
  EXPECT_NEAR(mean_square(true), 1.0, 4.0 * std::sqrt(2.0 / 2000.0));
}

TEST(Compensate, ATermThatRemainsIsInTheUncertainty) {
  EXPECT_NEAR(mean_square(false), 1.0, 4.0 * std::sqrt(2.0 / 2000.0));
}

TEST(Compensate, AMissingInputIsNamedAndItsTermRemains) {
  const Estimate estimate = result();
  const auto done = compensate(estimate, recording_of(values_of(estimate), {g}, {g}, false), nullptr);
  const Finding* remaining = finding_of(done.findings, "terms_remain");
  ASSERT_NE(remaining, nullptr);
  EXPECT_EQ(std::get<std::string>(remaining->values[0].value), "specific_force_y: cross");
  const double remainder = estimate.parameters[3].value * g * g;
  EXPECT_NEAR(done.recording.channels[0].values[0], g + remainder,
              2e-3 * remainder);  // times 1 + dE/du, here 1 - 0.6e-3
}

TEST(Compensate, BeyondTheCalibrationIsMarked) {
  const Estimate estimate = result();
  const std::vector<double> x{0.9 * g, 1.2 * g, -1.005 * g};
  const auto done = compensate(estimate, recording_of(values_of(estimate), x, {0.0, 0.0, 0.0}, true), nullptr);
  const auto& flags = find_channel(done.recording, "accelerometer.extrapolated")->values;
  EXPECT_EQ(flags, (std::vector<double>{0.0, 1.0, 0.0}));  // 1.01 of the range lies within its slack of 2 %
  const Finding* extrapolated = finding_of(done.findings, "extrapolated");
  ASSERT_NE(extrapolated, nullptr);
  EXPECT_EQ(extrapolated->occurrences.count, 1u);
  EXPECT_DOUBLE_EQ(extrapolated->occurrences.first.time, 0.01);
  EXPECT_DOUBLE_EQ(std::get<double>(extrapolated->values[0].value), 1.0 / 3.0);
}

TEST(Compensate, AnErrorAsLargeAsTheInputIsNoError) {
  Estimate estimate = result();
  estimate.parameters[2].value = 0.06;  // 0.06 u^2 changes by 1.2 times what u changes by at 1 g
  const auto done = compensate(estimate, recording_of(values_of(estimate), {0.01, g}, {0.0, 0.0}, true), nullptr);
  EXPECT_NEAR(done.recording.channels[0].values[0], 0.01, 1e-13);
  EXPECT_TRUE(std::isnan(done.recording.channels[0].values[1]));
  EXPECT_NE(finding_of(done.findings, "error_model_does_not_hold"), nullptr);
}

TEST(Compensate, MissingSamplesStayMissing) {
  const Estimate estimate = result();
  Recording recording = recording_of(values_of(estimate), {1.0, 2.0, 3.0}, {1.0, 1.0, 1.0}, true);
  recording.channels[0].values[0] = recording.channels[1].values[1] = std::nan("");
  const auto done = compensate(estimate, recording, nullptr);
  const auto& values = done.recording.channels[0].values;
  EXPECT_TRUE(std::isnan(values[0]) && std::isnan(values[1]));
  EXPECT_NEAR(values[2], 3.0, 1e-11);
  const Finding* missing = finding_of(done.findings, "input_missing");
  ASSERT_NE(missing, nullptr);
  EXPECT_EQ(missing->occurrences.count, 1u);
}

TEST(Compensate, ASlowerChannelIsReadBetweenItsSamples) {
  const Estimate estimate = result();
  Recording recording = recording_of(values_of(estimate), {1.0, 1.0, 1.0}, {0.0, 2.0, 4.0}, true);
  recording.channels[1].timeline.rate = 50.0;
  recording.channels[1].values = {0.0, 4.0};
  const auto done = compensate(estimate, recording, nullptr);
  for (const double u : done.recording.channels[0].values) EXPECT_NEAR(u, 1.0, 1e-12);
}

/// How the compensation by a changed result, or of a changed recording, ends.
Refused refused(const Estimate& estimate, const Recording& recording) {
  return refusal_of([&] { compensate(estimate, recording, nullptr); });
}

TEST(Compensate, RefusesAChannelInAnotherDimension) {
  Estimate estimate = result();
  const Recording recording = recording_of(values_of(estimate), {g}, {g}, true);
  estimate.models[0].scale.reset();
  estimate.models[0].recorded = estimate.models[0].unit;  // the channel is the specific force itself
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.values = {"accelerometer", "mA", "g"}}, refused(estimate, recording)));
}

TEST(Compensate, RefusesAParameterWithoutAValue) {
  Estimate estimate = result();
  const Recording recording = recording_of(values_of(estimate), {g}, {g}, true);
  estimate.parameters[3].value = std::nan("");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"cross"}}, refused(estimate, recording)));
}

TEST(Compensate, AnUnknownCovarianceGivesNoUncertainty) {
  Estimate estimate = result();
  for (double& value : estimate.covariance.values) value = std::nan("");
  const auto done = compensate(estimate, recording_of(values_of(estimate), {g}, {g}, true), nullptr);
  EXPECT_TRUE(std::isnan(find_channel(done.recording, "accelerometer.compensation_sd")->values[0]));
}

TEST(Compensate, RefusesWhatItCannotDo) {
  const Estimate estimate = result();
  const Recording recording = recording_of(values_of(estimate), {1.0}, {1.0}, true);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"accelerometer"}, .pattern = "no channel for the role"},
                      [&] { compensate(estimate, Recording{}, nullptr); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"accelerometer"}, .pattern = "compensated already"},
                      [&] { compensate(estimate, compensate(estimate, recording, nullptr).recording, nullptr); }));
  Estimate without = estimate;
  without.models.clear();
  EXPECT_TRUE(refuses(Error::Kind::unsupported, Asked{.pattern = "identifies no error model"},
                      [&] { compensate(without, recording, nullptr); }));
  const Plan empty;
  EXPECT_TRUE(refuses(Error::Kind::bad_input, {{.pattern = "[rig] kind"}, {.pattern = "[[schedule]]"}},
                      [&] { compensate(estimate, recording, &empty); }));
}

}  // namespace
}  // namespace tumble
