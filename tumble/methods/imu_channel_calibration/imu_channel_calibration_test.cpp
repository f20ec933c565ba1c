// Whole unit and channels alone against the instrument that both were simulated with, and what is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "tumble/math/matrix3.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::imu_channel_calibration_test {
namespace {

const Method& method() { return find_method("imu_channel_calibration"); }

/// Evidence of the trial's tests, carried out again with changed plans.
Evidence again(const std::function<void(Plan&)>& change) {
  Evidence evidence = trial_of(method(), 1).evidence;
  change(evidence.plan);
  for (std::size_t r = 0; r < evidence.recordings.size(); ++r) {
    if (evidence.plans[r]) {
      Plan part = *evidence.plans[r];
      change(part);
      evidence.plans[r] = std::make_shared<const Plan>(std::move(part));
    }
    evidence.recordings[r] = simulate(plan_of(evidence, r), r + 1, {});
  }
  return evidence;
}

/// Neither noise nor errors of rigs, outputs as they are.
void exact(Plan& plan) {
  plan.rig.set_flag("ideal", true);
  for (const char* name : {"gyro_angle_random_walk", "gyro_bias_instability", "accelerometer_angle_random_walk",
                           "accelerometer_bias_instability", "angle_random_walk", "bias_instability"})
    if (plan.truth.has(name)) plan.truth.set_number(name, 0.0, Unit::parse("1"));
  for (const char* name : {"gyro_output", "accelerometer_output"})
    if (plan.truth.has(name)) plan.truth.set_word(name, "as_output");
  if (plan.truth.has("output") && plan.instrument_model == "pendulous_accelerometer")
    plan.truth.set_word("output", "specific_force");
}

double truth(const Plan& plan, const std::string& name) { return plan.truth.number(name); }

/// M = (1 + S)^-1 and M b of the unit as simulated.
struct Expected {
  Matrix3 m;
  Vector3 nabla;
};

Expected expected(const Plan& plan, const std::string& kind) {
  const std::string letters = "xyz";
  Matrix3 s = identity3();
  Vector3 b;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string role = kind + "_" + letters[i];
    b[i] = truth(plan, role + "_bias");
    for (std::size_t j = 0; j < 3; ++j)
      s(i, j) += truth(plan, i == j ? role + "_scale_factor_error" : role + "_misalignment_" + letters[j]);
  }
  return {inverse(s), inverse(s) * b};
}

// Rounding of outputs of 10 m/s^2 and 0.5 rad/s over a well conditioned fit: 1e-14 relative, some tens of it.
TEST(ImuChannels, GivesTheTruthBackToRoundingWithoutNoise) {
  const Evidence evidence = again(exact);
  const auto estimate = method().identify(evidence, {});
  for (const std::string kind : {"accelerometer", "gyro"}) {
    const Expected right = expected(evidence.plan, kind);
    const double size = kind == "gyro" ? 0.5 : 10.0;
    EXPECT_NEAR(value(estimate, kind + "_x_bias"), right.nabla[0], 1e-12 * size) << kind;
    EXPECT_NEAR(value(estimate, kind + "_z_bias"), right.nabla[2], 1e-12 * size) << kind;
    EXPECT_NEAR(value(estimate, kind + "_y_scale_factor_error"), right.m(1, 1) - 1.0, 1e-12) << kind;
    EXPECT_NEAR(value(estimate, kind + "_x_misalignment_y"), right.m(0, 1), 1e-12) << kind;
    EXPECT_NEAR(value(estimate, kind + "_z_misalignment_x"), right.m(2, 0), 1e-12) << kind;
    const double k = truth(evidence.plan, kind + "_y_scale_factor_error"), b = truth(evidence.plan, kind + "_y_bias");
    EXPECT_NEAR(value(estimate, "split." + kind + "_y_scale_factor_error"), 1.0 / (1.0 + k) - 1.0, 1e-12) << kind;
    EXPECT_NEAR(value(estimate, "split." + kind + "_y_bias"), b / (1.0 + k), 1e-12 * size) << kind;
  }
}

double sd(const Estimate& estimate, const std::string& name) {
  return standard_uncertainty(estimate,
                              static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data()));
}

// gravity_sd is 5 ug, 5 ppm of every scale factor, of the unit and alone: it is not in the difference.
TEST(ImuChannels, GravityCancelsInTheDifference) {
  Evidence evidence = trial_of(method(), 1).evidence;
  const auto shared = method().identify(evidence, {});
  EXPECT_GT(sd(shared, "accelerometer_x_scale_factor_error"), 4.9e-6);
  EXPECT_GT(sd(shared, "split.accelerometer_x_scale_factor_error"), 4.9e-6);
  EXPECT_LT(sd(shared, "whole_minus_split.accelerometer_x_scale_factor_error"), 2.5e-6);
  const auto line = std::ranges::find(shared.budget, "gravity", &Contribution::source);
  ASSERT_NE(line, shared.budget.end());
  EXPECT_TRUE(line->key.starts_with("gravity 9.")) << line->key;  // one error of all channels and both ways
  EXPECT_EQ(line->factor.columns, 1u);
  for (auto& plan : evidence.plans) {
    if (!plan) continue;
    Plan part = *plan;
    part.site->gravity = *part.site->gravity + 1e-9;  // another place: its gravity was measured by itself
    plan = std::make_shared<const Plan>(std::move(part));
  }
  const auto apart = method().identify(evidence, {});
  EXPECT_GT(sd(apart, "whole_minus_split.accelerometer_x_scale_factor_error"), 7e-6);
}

/// Difference of the finding that names a term; 0: there is no such finding.
double difference_of(const Findings& findings, const std::string& term) {
  for (const Finding& finding : findings)
    if (finding.code == "term_differs" && finding.where == term) return std::get<double>(finding.values[0].value);
  return 0.0;
}

TEST(ImuChannels, ATermThatChangedIsNamed) {
  const auto same = method().identify(trial_of(method(), 1).evidence, {});
  EXPECT_EQ(difference_of(same.findings, "accelerometer_y_bias"), 0.0);
  const auto evidence = again([](Plan& plan) {
    if (plan.channels.contains("accelerometer_y"))
      plan.truth.set_number("bias", plan.truth.number("bias") + si(1.0, "mg"), Unit::parse("mg"));
  });
  const auto changed = method().identify(evidence, {});
  // the channel alone has a bias greater by 1 mg; misalignments of the unit are below 1e-3 of it
  const double change = si(1.0, "mg");
  EXPECT_NEAR(difference_of(changed.findings, "accelerometer_y_bias"), -change, 0.1 * change);
  EXPECT_LT(value_of(changed.findings, "terms_agree", "agreeing"), value_of(same.findings, "terms_agree", "terms"));
}

TEST(ImuChannels, AllThatIsMissingIsNamed) {
  Evidence evidence = trial_of(method(), 1).evidence;
  evidence.recordings.erase(evidence.recordings.begin() + 1, evidence.recordings.begin() + 3);
  evidence.plans.erase(evidence.plans.begin() + 1, evidence.plans.begin() + 3);
  std::erase_if(evidence.recordings[0].channels, [](const Channel& channel) { return channel.name == "gyro_z"; });
  const auto message = refusal(method(), evidence);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"accelerometer_x", "accelerometer_x"}}, message));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"accelerometer_y", "accelerometer_y"}}, message));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"gyro_z"}, .pattern = "no channel"}, message));
}

TEST(ImuChannels, AScheduleThatHidesATermIsRefusedWithItsName) {
  Evidence evidence = again([](Plan& plan) {
    if (plan.instrument_model == "imu")
      std::erase_if(plan.schedule, [](const Segment& segment) { return segment.label.starts_with("z at"); });
    for (auto& segment : plan.schedule)
      if (segment.label.starts_with("y at")) segment.axes["inner"].value = 0.0;
  });
  const auto message = refusal(method(), evidence);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.part = "gyro_", .pattern = "does not show"}, message));
}

TEST(ImuChannels, WithoutGyrosTheAccelerometersStand) {
  Evidence evidence = trial_of(method(), 1).evidence;
  evidence.recordings.resize(4);
  evidence.plans.resize(4);
  const auto estimate = method().identify(evidence, {});
  EXPECT_NE(find_parameter(estimate, "whole_minus_split.accelerometer_z_bias"), nullptr);
  EXPECT_EQ(find_parameter(estimate, "gyro_x_bias"), nullptr);
  EXPECT_NE(finding_of(estimate.findings, "no_gyro_tested_alone"), nullptr);
}

// One gyro has another bias in the power-up in which it was alone: nothing says which of the two is usual.
TEST(ImuChannels, ABiasThatDoesNotRepeatIsNamedAndInTheUncertaintyOfBoth) {
  Trial trial = trial_of(method(), 1);
  const Estimate sound = method().identify(trial.evidence, {});
  for (Channel& channel : trial.evidence.recordings[4].channels)  // after the unit and three accelerometers
    if (channel.name == "gyro_x")
      for (double& count : channel.values) count += 1.0;
  const Estimate estimate = method().identify(trial.evidence, {});
  EXPECT_TRUE(std::ranges::any_of(estimate.findings, [](const Finding& finding) {
    return finding.code == "term_differs" && finding.where == "gyro_x_bias";
  }));
  for (const char* name : {"gyro_x_bias", "split.gyro_x_bias", "whole_minus_split.gyro_x_bias"}) {
    const auto i = static_cast<std::size_t>(find_parameter(estimate, name) - estimate.parameters.data());
    const double truth = std::ranges::find(trial.truth, name, &std::pair<std::string, double>::first)->second;
    EXPECT_LT(std::abs(estimate.parameters[i].value - truth), 3.0 * standard_uncertainty(estimate, i)) << name;
    EXPECT_GT(standard_uncertainty(estimate, i), 3.0 * standard_uncertainty(sound, i)) << name;
  }
}

// The bias of one gyro is 0.08 deg/h lower when it is tested alone, by 4 of the sd of the difference: too little to be said in every test.
TEST(ImuChannels, ABiasOfOneChannelThatDoesNotRepeatIsInTheUncertainty) {
  double squares = 0.0;
  constexpr int seeds = 6;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Trial trial = trial_of(method(), seed);
    for (Channel& channel : trial.evidence.recordings[4].channels) {
      double rest = 0.0;
      if (channel.name != "gyro_x") continue;
      for (double& counts : channel.values) {  // ten a second, of 0.1 arcsec
        rest -= 0.08;
        counts += std::round(rest), rest -= std::round(rest);
      }
    }
    const Estimate estimate = method().identify(trial.evidence, {});
    const auto i = static_cast<std::size_t>(find_parameter(estimate, "split.gyro_x_bias") - estimate.parameters.data());
    const double bias =
        std::ranges::find(trial.truth, "split.gyro_x_bias", [](const auto& one) { return one.first; })->second;
    const double half =
        student_quantile(0.975, estimate.parameters[i].degrees_of_freedom) * standard_uncertainty(estimate, i);
    squares += std::pow((estimate.parameters[i].value - bias) * 1.96 / half, 2);
  }
  EXPECT_LT(std::sqrt(squares / seeds), 2.2);
}

}  // namespace
}  // namespace tumble::imu_channel_calibration_test
