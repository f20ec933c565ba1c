#include <gtest/gtest.h>

#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::accelerometer_centrifuge_test {
namespace {

const Method& method() { return find_method("accelerometer_centrifuge"); }

/// The trial without noise, counting and errors of the rigs, as a voltage.
Trial clean(double lever_mm) {
  Trial trial = trial_of(method(), 1);
  const auto exact = [](Plan plan) {
    plan.rig.set_flag("ideal", true);
    for (const char* name : {"angle_random_walk", "bias_instability"}) plan.truth.set_number(name, 0.0, Unit());
    plan.truth.set_word("output", "voltage");
    plan.truth.set_number("voltage_scale_factor", si(0.5, "V/g"), Unit::parse("V/g"));
    return plan;
  };
  auto& evidence = trial.evidence;
  evidence.plan = exact(evidence.plan);
  evidence.plans[1] = std::make_shared<const Plan>(exact(*evidence.plans[1]));
  Plan real = evidence.plan;
  real.rig.set_number("lever_x", si(lever_mm, "mm"), Unit::parse("mm"));
  real.recordings.clear();
  evidence.recordings = {simulate(real, 1, {}), simulate(*evidence.plans[1], 2, {})};
  return trial;
}

/// Without the tumble.
void leave_the_arm_alone(Evidence& evidence) {
  evidence.recordings.resize(1);
  evidence.plans.clear();
  evidence.plan.recordings.clear();
}

// Exact to rounding but for how the radius' term is taken: the Earth's rate turns the axis of rotation by 1e-5 rad from
// the arm's, and the fit stops when the radius moves by less than 1e-7 m. 2e-4 of a coefficient is far below any noise.
TEST(AccelerometerCentrifuge, NoiseFreeTestsGiveTheTruthAlsoOfARadiusFarOff) {
  for (const double lever : {0.0, 1.3, 40.0}) {
    const Trial trial = clean(lever);
    const auto estimate = method().identify(trial.evidence, {});
    for (const auto& [name, truth] : trial.truth) {
      if (name == "scale_factor" || name == "effective_radius" || name == "centre_offset") continue;
      EXPECT_NEAR(value(estimate, name), truth, 2e-4 * std::abs(truth)) << name << " with " << lever << " mm";
    }
    EXPECT_NEAR(value(estimate, "scale_factor"), si(0.5, "V/g"), 1e-8 * si(0.5, "V/g"));
    EXPECT_NEAR(value(estimate, "effective_radius"), 1.2 + 1e-3 * lever, 1e-7);
    EXPECT_NEAR(value(estimate, "centre_offset"), 0.0, 1e-7);
  }
}

// Annex of the closed forms: even part K_0' + K_2 a^2, odd part a + K_3 a^3 + K_oq a^2, K_0' with what 1 g across adds.
TEST(AccelerometerCentrifuge, EvenAndOddPartsOfTheLevelsAreTheModel) {
  const Trial trial = clean(0.0);
  const auto estimate = method().identify(trial.evidence, {});
  const Table* levels = find_table(estimate, "levels");
  ASSERT_NE(levels, nullptr);
  ASSERT_EQ(levels->rows.size(), 12u);
  const auto cell = [&](std::size_t row, std::size_t column) { return std::get<double>(levels->rows[row][column]); };
  const auto even = [&](std::size_t k) { return 0.5 * (cell(k, 5) + cell(k + 6, 5)); };
  const auto odd = [&](std::size_t k) { return 0.5 * (cell(k + 6, 5) - cell(k, 5)); };
  const auto truth = [&](const char* name) { return trial.evidence.plan.truth.number(name); };
  const double k_2 = truth("second_order_coefficient"), k_3 = truth("third_order_coefficient");
  const double k_oq = truth("odd_quadratic_coefficient");
  for (std::size_t k = 0; k < 6; ++k) {
    const double a = cell(k, 2), one_g = 9.7954;
    EXPECT_EQ(std::get<std::string>(levels->rows[k][3]), "outward");
    EXPECT_EQ(std::get<std::string>(levels->rows[k + 6][3]), "inward");
    EXPECT_NEAR(even(k) - even(0), k_2 * (a * a - cell(0, 2) * cell(0, 2)), 1e-6);
    EXPECT_NEAR(odd(k), a + k_3 * a * a * a + k_oq * a * a + truth("cross_coupling_io") * a * one_g, 2e-6);
  }
}

TEST(AccelerometerCentrifuge, TheArmAloneDoesNotDistinguishRadiusFromScaleFactor) {
  Trial trial = clean(1.3);
  leave_the_arm_alone(trial.evidence);
  const auto estimate = method().identify(trial.evidence, {});
  EXPECT_EQ(find_parameter(estimate, "effective_radius"), nullptr);
  EXPECT_TRUE(has_finding(estimate.findings, "radius_in_scale_factor"));
  EXPECT_EQ(text_of(estimate.findings, "gravity_across_at_all_levels", "symbol"), "K_io");
  EXPECT_EQ(text_of(estimate.findings, "gravity_across_at_all_levels", "meanings"), "scale_factor (1 + K_io)");
  // 1 + 1.3 mm/1.2 m, and K_io times 1 g = -14e-6
  EXPECT_NEAR(value(estimate, "scale_factor") / si(0.5, "V/g"), (1.0 + 1.3 / 1200.0) * (1.0 - 14e-6), 1e-6);
}

TEST(AccelerometerCentrifuge, AKnownScaleFactorShowsTheRadius) {
  Trial trial = clean(1.3);
  leave_the_arm_alone(trial.evidence);
  auto& settings = trial.evidence.plan.settings;
  settings.set_word("scale_factor", "0.5 V/g");
  settings.set_number("scale_factor_sd", 20e-6, Unit::parse("ppm"));
  const auto estimate = method().identify(trial.evidence, {});
  EXPECT_EQ(find_parameter(estimate, "scale_factor"), nullptr);
  EXPECT_NEAR(value(estimate, "effective_radius"), 1.2013 * (1.0 - 14e-6), 1e-6);
  const auto* radius = find_parameter(estimate, "effective_radius");
  const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(radius - estimate.parameters.data()));
  EXPECT_NEAR(sd, 20e-6 * 1.2, 2e-7);  // 20 ppm of 1.2 m
  settings.set_word("scale_factor", "");
  EXPECT_NE(refusal(method(), trial.evidence).find("give both, or neither"), std::string::npos);
}

// With 4 mm K_2 would be off by 3 K_3 e/R a^2 of it, 18 %, if the force at which it is taken lacked e.
TEST(AccelerometerCentrifuge, AnEffectiveCentreOffTheMountingIsDistinguishedFromTheRadius) {
  for (const double e : {2e-4, -4e-3}) {
    Trial trial = clean(0.0);
    // the instrument is turned about its mounting's centre: 0.2 mm further out in one sense, further in in the other
    const auto sense = [&](double lever, std::size_t from, std::size_t to) {
      Plan plan = trial.evidence.plan;
      plan.recordings.clear();
      plan.rig.set_number("lever_x", lever, Unit::parse("mm"));
      const auto recording = simulate(plan, 1, {});
      auto& values = trial.evidence.recordings[0].channels[0].values;
      for (std::size_t i = from; i < to; ++i) values[i] = recording.channels[0].values[i];
    };
    const std::size_t all = trial.evidence.recordings[0].channels[0].values.size();
    sense(e, 0, all / 2);
    sense(-e, all / 2, all);
    const auto estimate = method().identify(trial.evidence, {});
    EXPECT_NEAR(value(estimate, "effective_radius"), 1.2, 1e-7);
    EXPECT_NEAR(value(estimate, "centre_offset"), e, 1e-7);
    for (const char* name : {"second_order_coefficient", "third_order_coefficient", "odd_quadratic_coefficient"}) {
      const double truth = trial.evidence.plan.truth.number(name);
      EXPECT_NEAR(value(estimate, name), truth, 2e-4 * std::abs(truth)) << name << " with " << e << " m";
    }
  }
}

// Both go with w^4: s w^4 = K_oq (w^2 R)^2, K_oq = s/R^2.
TEST(AccelerometerCentrifuge, AStretchOfTheRadiusIsInTheBudgetOfTheOddQuadraticTerm) {
  const auto estimate = method().identify(trial_of(method(), 3).evidence, {});
  const auto* odd = find_parameter(estimate, "odd_quadratic_coefficient");
  const auto j = static_cast<std::size_t>(odd - estimate.parameters.data());
  double stretch = 0.0;
  for (const auto& line : estimate.budget)
    if (line.source == "stretch of the radius") stretch = std::sqrt(line.variance(j));
  EXPECT_NEAR(stretch, 0.2e-6 / (1.2 * 1.2), 0.02 * 0.2e-6 / 1.44);
  EXPECT_EQ(value_of(estimate.findings, "stretch_like_odd_quadratic", "share"), stretch);
}

// Bad input

TEST(AccelerometerCentrifuge, OneSenseAloneIsNamed) {
  Trial trial = clean(0.0);
  trial.evidence.recordings[0].marks.resize(8);
  trial.evidence.recordings[0].channels[0].values.resize(880);
  const auto estimate = method().identify(trial.evidence, {});
  EXPECT_EQ(find_parameter(estimate, "centre_offset"), nullptr);
  EXPECT_TRUE(says(estimate.findings, "the input axis points outwards at all levels"));
  EXPECT_TRUE(has_finding(estimate.findings, "one_sense_of_the_arm"));
}

TEST(AccelerometerCentrifuge, ALevelThatClipsIsRefused) {
  Trial trial = clean(0.0);
  const double most = 0.5 * 15.5;  // V: the levels at 20 g are beyond
  for (auto& v : trial.evidence.recordings[0].channels[0].values) v = std::clamp(v, -most, most);
  EXPECT_NE(refusal(method(), trial.evidence).find("clipped"), std::string::npos);
}

TEST(AccelerometerCentrifuge, AnArmThatDoesNotSettleIsNamed) {
  Trial trial = clean(0.0);
  auto& values = trial.evidence.recordings[0].channels[0].values;
  for (std::size_t i = 460; i < 580; ++i) values[i] *= 1.0 - 0.02 * std::exp(-static_cast<double>(i - 460) / 60.0);
  const auto findings = method().identify(trial.evidence, {}).findings;
  const Finding* finding = finding_of(findings, "segment_still_changes");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->occurrences.count, 1u);
  EXPECT_EQ(finding->occurrences.worst.label, "517 deg/s, yaw 0");
}

TEST(AccelerometerCentrifuge, AnArmThatStandsIsRefused) {
  Trial trial = clean(0.0);
  trial.evidence.plan = *trial.evidence.plans[1];
  trial.evidence.plan.method = "accelerometer_centrifuge";
  trial.evidence.recordings.erase(trial.evidence.recordings.begin());
  trial.evidence.plans.clear();
  EXPECT_NE(refusal(method(), trial.evidence).find("centrifuge"), std::string::npos);
}

}  // namespace
}  // namespace tumble::accelerometer_centrifuge_test
