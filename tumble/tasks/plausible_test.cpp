#include "tumble/tasks/plausible.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/core/budget.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/rigs/capabilities.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

Estimate with(const char* name, double value, const char* unit) {
  Estimate estimate;
  estimate.parameters.push_back({name, name, Unit::parse(unit), si(value, unit), ""});
  estimate.covariance = Matrix(1, 1);
  return estimate;
}

TEST(Plausible, SoundValuesAreNotAccused) {
  EXPECT_TRUE(implausible(with("scale_factor_error", 19.0, "%"), Plan{}).empty());
  EXPECT_TRUE(implausible(with("scale_factor_error", -3000.0, "ppm"), Plan{}).empty());
  EXPECT_TRUE(implausible(with("misalignment_o", -2.9, "deg"), Plan{}).empty());
  EXPECT_TRUE(implausible(with("scale_factor", 0.442, "pulse/arcsec"), Plan{}).empty());
  EXPECT_TRUE(implausible(with("gyro_x_scale_factor_error", 35.0, "%"), Plan{}).empty());  // a raw part of several axes
}

TEST(Plausible, WhatIsBeyondTheRangeOfNumbersIsAnError) {
  Estimate estimate = with("bias", 1e200, "deg/h");
  estimate.covariance(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(implausible(estimate, Plan{}).at(0).code, "out_of_range");
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), 1e293, -1e-312})
    EXPECT_EQ(implausible(with("bias", value, "deg/h"), Plan{}).at(0).code, "out_of_range");
}

TEST(Plausible, ASignOrASizeOutOfReachIsAnError) {
  for (const auto& [estimate, code] : {std::pair{with("scale_factor_error", -2e6, "ppm"), "wrong_sign"},
                                       std::pair{with("gyro_x_scale_factor_error", -2.0, "1"), "wrong_sign"},
                                       std::pair{with("scale_factor", -0.44, "pulse/arcsec"), "wrong_sign"},
                                       std::pair{with("effective_radius", -1197.7, "mm"), "wrong_sign"},
                                       std::pair{with("scale_factor_error", 25.0, "%"), "beyond_linear_form"},
                                       std::pair{with("misalignment_S", 57.0, "deg"), "beyond_linear_form"}}) {
    const Findings findings = implausible(estimate, Plan{});
    ASSERT_EQ(findings.size(), 1u) << estimate.parameters[0].name;
    EXPECT_EQ(findings[0].code, code);
    EXPECT_EQ(findings[0].severity, Finding::Severity::error);
    Estimate answer = estimate;
    answer.parameters.push_back({"bias", "B", Unit::parse("deg/h"), 0.0, ""});
    answer.findings = findings;
    settle_findings(answer);
    EXPECT_TRUE(is_undermined(answer, estimate.parameters[0].name));
    EXPECT_EQ(is_undermined(answer, "bias"), findings[0].code == "wrong_sign");
  }
}

TEST(Plausible, AGainOfAnotherUnitIsAnError) {
  const auto codes_of = [](const char* name, double value) {
    Findings findings = implausible(with(name, value, "1"), Plan{});
    std::erase_if(findings, [](const Finding& one) { return one.code == "beyond_linear_form"; });
    return findings.empty() ? std::string() : findings[0].code;
  };
  EXPECT_EQ(codes_of("scale_factor_error", 0.0175 - 1.0), "gain_of_another_unit");
  EXPECT_EQ(codes_of("scale_factor_error", 9.9 - 1.0), "gain_of_another_unit");
  EXPECT_EQ(codes_of("gyro_y_scale_factor_error", 57.0 - 1.0), "gain_of_another_unit");
  EXPECT_EQ(codes_of("split.gyro_y_scale_factor_error", 0.0172 - 1.0), "gain_of_another_unit");
  EXPECT_EQ(codes_of("accelerometer_z_scale_factor", 9.81), "gain_of_another_unit");
  EXPECT_EQ(codes_of("accelerometer_z_scale_factor", 0.0175), "");  // rates have degrees
  EXPECT_EQ(codes_of("gyro_y_scale_factor_error", 0.5), "");
  EXPECT_EQ(codes_of("whole_minus_split.gyro_y_scale_factor_error", 0.0175 - 1.0), "");
  EXPECT_EQ(codes_of("bias", 0.0175), "");
}

TEST(Plausible, ARadiusUnlikeThatOfThePlanIsAnError) {
  Plan plan = trial_of(find_method("accelerometer_centrifuge"), 1).evidence.plan;
  plan.rig.set_number("radius_sd", si(20.0, "um"), Unit::parse("um"));
  plan.rig.set_number("lever_sd", si(1.0, "mm"), Unit::parse("mm"));
  ASSERT_TRUE(is_fixed_on_arm(plan));
  const double nominal = plan.rig.number("radius") + plan.rig.number("lever_x");
  const double sd = std::hypot(plan.rig.number("radius_sd"), plan.rig.number("lever_sd"));
  Estimate estimate = with("effective_radius", 1e3 * (nominal + 3.9 * sd), "mm");
  estimate.covariance = Matrix(1, 1);
  EXPECT_TRUE(implausible(estimate, plan).empty());
  estimate.parameters[0].value = nominal - 4.1 * sd;
  ASSERT_EQ(implausible(estimate, plan).size(), 1u);
  EXPECT_EQ(implausible(estimate, plan)[0].code, "radius_unlike_plan");
  Estimate answer = estimate;
  answer.parameters.push_back({"bias", "B", Unit::parse("deg/h"), 0.0, ""});
  answer.findings = implausible(estimate, plan);
  settle_findings(answer);
  EXPECT_TRUE(is_undermined(answer, "effective_radius"));
  EXPECT_FALSE(is_undermined(answer, "bias"));
  estimate.covariance(0, 0) = sd * sd;  // the answer itself is no better known than the plan
  EXPECT_TRUE(implausible(estimate, plan).empty());
}

TEST(Plausible, GravityOfAnotherPlaceIsSaid) {
  Plan plan;
  EXPECT_TRUE(about_site(plan).empty());
  plan.site = Site{.latitude = si(34.25, "deg"), .height = 400.0};
  EXPECT_TRUE(about_site(plan).empty());
  plan.site->gravity = 9.7970;  // 8e-5 beside normal gravity
  EXPECT_TRUE(about_site(plan).empty());
  plan.site->gravity = 9.8122;  // of Potsdam
  ASSERT_EQ(about_site(plan).size(), 1u);
  EXPECT_EQ(about_site(plan)[0].code, "gravity_of_another_place");
  plan.site->height.reset();  // not stated: a mountain is possible, but it makes gravity smaller by 0.14 % at most
  EXPECT_EQ(about_site(plan).size(), 1u);
  plan.site->gravity = normal_gravity(plan.site->latitude, 4000.0);
  EXPECT_TRUE(about_site(plan).empty());
}

// The output of every trial with one gyro or accelerometer turned about: each method says so, and no limit is decided.
TEST(Plausible, AnOutputThatIsTurnedAboutIsSaid) {
  for (const char* name : {"accelerometer_dynamic", "gyro_scale_factor", "sdof_gyro_dynamic"}) {
    Evidence evidence = trial_of(find_method(name), 1).evidence;
    const char* role = std::string(name).starts_with("accelerometer") ? "accelerometer" : "gyro";
    for (Recording& recording : evidence.recordings)
      for (Channel& channel : recording.channels)
        if (channel.name == role || channel.name == "output")
          for (double& value : channel.values) value = -value;
    evidence.plan.method = name;
    evidence.plan.limits = {{"bias", std::nullopt, Quantity{1e9, Unit::parse("deg/h"), false}, "plan.toml:1"}};
    if (role == std::string("accelerometer")) evidence.plan.limits[0].max = Quantity{1e9, Unit::parse("g"), false};
    const Estimate estimate = identify(evidence, {});
    EXPECT_TRUE(std::ranges::any_of(estimate.findings, [](const Finding& one) { return one.code == "wrong_sign"; }))
        << name;
    for (const Verdict& verdict : estimate.verdicts) EXPECT_EQ(verdict.outcome, Verdict::Outcome::undecided) << name;
  }
}

/// A latitude that no residual shows, and gravity by the formula, are named where they rule a parameter.
TEST(Plausible, WhatTheSiteRulesIsSaid) {
  Plan plan;
  plan.site = Site{.latitude = si(34.25, "deg"), .height = {}, .gravity = {}, .latitude_sd = si(60.0, "arcsec")};
  Estimate estimate;
  estimate.parameters = {{"bias", "", Unit::parse("deg/h"), 0.0, ""}, {"scale_factor", "", Unit(), 1.0, ""}};
  const auto line = [](const char* source, double of_bias, double of_scale) {
    Contribution out{source, "", Matrix(2, 1)};
    out.factor(0, 0) = of_bias, out.factor(1, 0) = of_scale;
    return out;
  };
  estimate.budget = {line("latitude", 3.0, 0.0), line("gravity", 0.0, 1.0), line("noise", 1.0, 0.5)};
  estimate.covariance = covariance_of(estimate.budget, 2);
  const auto findings = ruled_by_site(plan, estimate);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].code, "latitude_rules");
  EXPECT_EQ(findings[0].occurrences.worst.label, "bias");
  EXPECT_EQ(findings[1].code, "gravity_by_formula_rules");
  EXPECT_EQ(findings[1].severity, Finding::Severity::info);
  plan.site->gravity = 9.797;
  EXPECT_EQ(ruled_by_site(plan, estimate).size(), 1u);
  estimate.budget[0] = line("latitude", 0.5, 0.0);
  estimate.covariance = covariance_of(estimate.budget, 2);
  EXPECT_TRUE(ruled_by_site(plan, estimate).empty());
}

Estimate with_channels() {
  const auto parameter = [](const char* name, std::vector<std::string> channels) {
    Parameter out{name, "", Unit(), 1.0, ""};
    out.channels = std::move(channels);
    return out;
  };
  Estimate estimate;
  estimate.parameters = {parameter("gyro.angle_random_walk", {"gyro"}), parameter("gyro_x_bias", {"gyro_x"}),
                         parameter("bias", {})};
  return estimate;
}

using Each = std::vector<bool>;

/// Which parameters an error undermines.
Each undermined(Finding finding) {
  Estimate estimate = with_channels();
  estimate.findings = {std::move(finding)};
  settle_findings(estimate);
  Each out;
  for (const auto& one : estimate.parameters) out.push_back(is_undermined(estimate, one.name));
  return out;
}

// An error undermines the parameters that it is about.
TEST(Plausible, AnErrorUnderminesTheParametersThatItNames) {
  Finding error{Finding::Severity::error, "no_samples", {}, ""};
  error.about = {0, 2};
  EXPECT_EQ(undermined(error), (Each{true, false, true}));
  error.severity = Finding::Severity::warning;
  EXPECT_EQ(undermined(error), (Each{false, false, false}));
  error = {Finding::Severity::error, "wrong_sign", {{"value", 1.0}, {"limit", 2.0}, {"parameter", "bias"}}, "bias"};
  EXPECT_EQ(undermined(error), (Each{true, true, true})) << "a sign is that of the set-up";
}

// An error that names a channel undermines what its samples give; one that names no parameter undermines all.
TEST(Plausible, AnErrorThatNamesNoParameterUnderminesAll) {
  const auto at = [](const char* where) { return undermined({Finding::Severity::error, "no_samples", {}, where}); };
  EXPECT_EQ(at("bias"), (Each{false, false, true}));
  EXPECT_EQ(at("gyro_x"), (Each{false, true, true})) << "all channels give the bias";
  EXPECT_EQ(at("gyro"), (Each{true, false, true}));
  for (const char* where : {"", "today.csv", "today.csv, gyro", "accelerometer", "hold at 20 degC"})
    EXPECT_EQ(at(where), (Each{true, true, true})) << where;
}

// A parameter that the data hide is undermined by what is wrong with the channel that hides it.
TEST(Plausible, AnErrorUnderminesWhatItsChannelHides) {
  Estimate estimate = with_channels();
  estimate.findings = {{Finding::Severity::error, "no_samples", {}, "gyro"},
                       {Finding::Severity::info, "not_significant", {{"parameter", "b"}, {"limit", 1.0}}}};
  estimate.findings[1].hidden = {{"gyro.rate_random_walk", "gyro"}, {"gyro_x.rate_random_walk", "gyro_x"}};
  settle_findings(estimate);
  EXPECT_TRUE(is_undermined(estimate, "gyro.rate_random_walk"));
  EXPECT_FALSE(is_undermined(estimate, "gyro_x.rate_random_walk"));
  EXPECT_TRUE(is_undermined(estimate, "known_to_a_prior_alone"));
}

}  // namespace
}  // namespace tumble
