#include "tumble/reduce/rig_effects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/rigs/testing/error_names.hpp"

namespace tumble {
namespace {

namespace names = error_names;

Plan head_plan(std::vector<Segment> schedule) {
  Plan plan;
  plan.rig_kind = "dividing_head";
  plan.rig = defaults(find_rig("dividing_head").options());
  plan.site = Site{.latitude = 0.6};
  plan.sample_rate = 1.0;
  plan.schedule = std::move(schedule);
  return plan;
}

Segment held(const std::string& label, double angle) {
  return {label, 60.0, 1, {{"head", {.kind = Motion::Kind::hold, .value = angle}}}};
}

/// One row a stretch: along a direction between x and y, so that the head's angle moves it at every quarter turn.
Observation rows_of(const ConductedTest& test) {
  Observation observation;
  for (std::size_t g = 0; g < test.stretches.size(); ++g) observation.stretch.push_back(g);
  observation.add = [&test](const Reference& reference, std::size_t g, Detail, OutputRows rows) {
    Felt felt;
    reference.felt(test.stretches[g].first + 0.5 * test.stretches[g].duration(), 1.0, std::span(&felt, 1));
    rows[0][0] += felt.specific_force.x + felt.specific_force.y;
  };
  return observation;
}

/// Those of the only output.
std::vector<KnownEffect> effects_of(const ConductedTest& test, const Observation& observation) {
  return rig_effects(test, observation).at(0);
}

std::vector<KnownEffect> effects_named(const std::vector<KnownEffect>& all, const std::string& source) {
  std::vector<KnownEffect> some;
  std::ranges::copy_if(all, std::back_inserter(some), [&](const auto& effect) { return effect.source == source; });
  return some;
}

TEST(RigEffects, GravityMovesEveryRowByItsShareOfGravity) {
  const Plan plan = head_plan({held("a", 0.0), held("b", 0.5 * std::numbers::pi)});
  const auto test = stretches(plan, {.role = "accelerometer"});
  const auto all = effects_of(test, rows_of(test));
  const auto gravity = effects_named(all, names::gravity);
  ASSERT_EQ(gravity.size(), 1u);
  EXPECT_FALSE(gravity[0].each_segment);
  // |x + y| is the specific force itself at quarter turns; differences of 9.8 m/s^2 are rounded to 4e-15
  for (const double shift : gravity[0].column) EXPECT_NEAR(std::abs(shift), *rig_sd(plan, names::gravity), 1e-14);
}

TEST(RigEffects, StretchesAtOneAngleShareItsPositioning) {
  Segment stays = held("stays", 0.0);
  stays.axes.clear();
  const Plan plan = head_plan({held("a", 0.0), held("b", 0.5 * std::numbers::pi), stays, held("c", std::numbers::pi)});
  const auto test = stretches(plan, {.role = "accelerometer"});
  ASSERT_EQ(test.stretches.size(), 4u);
  const auto effects = effects_named(effects_of(test, rows_of(test)), std::string(names::positioning_of) + "head");
  ASSERT_EQ(effects.size(), 2u);
  const auto& shared = effects[0];
  EXPECT_FALSE(shared.each_segment);
  EXPECT_EQ(shared.draws, std::vector<std::string>{"positioning of head, segment 'b' (2 of power-up 1, run 1)"});
  EXPECT_EQ(shared.column[0], 0.0);
  EXPECT_NE(shared.column[1], 0.0);
  EXPECT_EQ(shared.column[1], shared.column[2]);
  EXPECT_EQ(shared.column[3], 0.0);
  const auto& own = effects[1];
  EXPECT_TRUE(own.each_segment);
  EXPECT_EQ(own.column[1], 0.0);
  // g times the angle; the second order of 1 arcsec is 1e-11 of it
  const double sd = *rig_sd(plan, std::string(names::positioning_of) + "head");
  EXPECT_NEAR(std::abs(own.column[0]) / (sd * 9.8), 1.0, 0.01);
}

TEST(RigEffects, ErrorsOfDifferentPlansAreDifferent) {
  Plan plan = head_plan({held("a", 0.0)});
  Plan elsewhere = plan;
  elsewhere.site->gravity = gravity(*plan.site) + 1e-9;  // measured by itself
  plan.recordings = {{.file = "other.csv", .plan = std::make_shared<const Plan>(elsewhere)}};
  const auto test = stretches(plan, {.role = "accelerometer"});
  ASSERT_EQ(test.plans, 2u);
  const auto gravity = effects_named(effects_of(test, rows_of(test)), names::gravity);
  ASSERT_EQ(gravity.size(), 2u);
  EXPECT_EQ(gravity[0].draws, std::vector<std::string>{"gravity"});
  EXPECT_EQ(gravity[1].draws, std::vector<std::string>{"gravity of plan 2"});
  EXPECT_EQ(gravity[0].column[1], 0.0);
  EXPECT_EQ(gravity[1].column[0], 0.0);
  EXPECT_NE(gravity[1].column[1], 0.0);
}

TEST(RigEffects, PlansOfOneRigAndSiteShareTheirErrors) {
  Plan plan = head_plan({held("a", 0.0)});
  plan.rig_equipment = "head 7, certificate 12";
  plan.recordings = {{.file = "other.csv", .plan = std::make_shared<const Plan>(plan)}};
  const auto test = stretches(plan, {.role = "accelerometer"});
  ASSERT_EQ(test.plans, 2u);
  const auto all = effects_of(test, rows_of(test));
  const auto of_site = effects_named(all, names::gravity);
  ASSERT_EQ(of_site.size(), 1u);
  EXPECT_TRUE(of_site[0].key.starts_with("gravity 9.")) << of_site[0].key;
  EXPECT_NEAR(of_site[0].column[0], of_site[0].column[1], 1e-14);
  std::size_t of_rig = 0;
  for (const auto& effect : all) of_rig += effect.key == "head 7, certificate 12";
  EXPECT_GT(of_rig, 0u);
}

// A worse value of gravity beside a good one would otherwise show the good one's error by their ratio.
TEST(RigEffects, PlansThatStateDifferentUncertaintiesDoNotShare) {
  Plan plan = head_plan({held("a", 0.0)});
  Plan worse = plan;
  worse.rig.set_number("gravity_sd", 10.0 * *rig_sd(plan, names::gravity), Unit::parse("ug"));
  plan.recordings = {{.file = "other.csv", .plan = std::make_shared<const Plan>(worse)}};
  const auto test = stretches(plan, {.role = "accelerometer"});
  const auto of_site = effects_named(effects_of(test, rows_of(test)), names::gravity);
  ASSERT_EQ(of_site.size(), 2u);
  EXPECT_FALSE(of_site[0].key.empty());
  EXPECT_TRUE(of_site[1].key.empty());
}

TEST(RigEffects, ObservedWithErrorsIsTheDifferenceThatTheColumnsHold) {
  const Plan plan = head_plan({held("a", 0.0), held("b", 0.5 * std::numbers::pi)});
  const auto test = stretches(plan, {.role = "accelerometer"});
  const auto observe = [](const Reference& reference, const Stretch& stretch) {
    Felt felt;
    reference.felt(stretch.first + 0.5 * stretch.duration(), 1.0, std::span(&felt, 1));
    return felt.specific_force.x + felt.specific_force.y;
  };
  std::vector<const Stretch*> all;
  std::vector<double> nominal;
  for (const auto& stretch : test.stretches) {
    all.push_back(&stretch);
    nominal.push_back(observe(test.power_ups[stretch.power_up].reference, stretch));
  }
  const auto effects = effects_of(test, rows_of(test));
  for (const auto& with : observed_with_errors(test.power_ups, all, nominal, observe)) {
    if (with.error.error.each_segment) continue;
    const auto columns = effects_named(effects, with.error.error.name);
    for (std::size_t g = 0; g < all.size(); ++g) {
      const double column = columns.empty() ? 0.0 : columns[0].column[g];
      EXPECT_NEAR(with.observed[g] - nominal[g], column, 1e-12) << with.error.error.name;  // 1e-13 of g is rounding
    }
  }
}

TEST(RigEffects, EachSegmentOfEveryStartIsADraw) {
  const Plan plan = head_plan({held("a", 0.0), held("b", 1.0)});
  const auto test = stretches(plan, {.role = "accelerometer"});
  std::size_t of_positioning = 0;
  for (const auto& draw : draws_of({&test})) {
    EXPECT_EQ(draw.only.has_value(), draw.error.error.each_segment);
    of_positioning += draw.error.error.name == std::string(names::positioning_of) + "head" ? 1 : 0;
  }
  EXPECT_EQ(of_positioning, 2u);
}

TEST(RigSd, IsAbsentWhereTheRigHasNoSuchError) {
  Plan plan = head_plan({held("a", 0.0)});
  EXPECT_TRUE(rig_sd(plan, names::gravity).has_value());
  EXPECT_FALSE(rig_sd(plan, names::shake_amplitude).has_value());
  plan.rig_kind.clear();
  EXPECT_FALSE(rig_sd(plan, names::gravity).has_value());
}

TEST(RigSd, EveryErrorOfEveryRigHasAKnownName) {
  for (const Rig* rig : rig_catalogue())
    for (const auto& error : rig->errors(defaults(rig->options()), {}))
      EXPECT_TRUE(is_error_name(error.name)) << rig->name << ": " << error.name;
}

/// A rate along x of a head that stands at three angles about the east-west line.
TEST(RigEffects, TheLatitudeTurnsTheEarthsRateAndIsOfTheSite) {
  Plan plan = head_plan({held("a", 0.0), held("b", 0.5 * std::numbers::pi), held("c", 1.0)});
  plan.site->latitude_sd = 1e-5;
  const auto test = stretches(plan, {.role = "gyro"});
  Observation observation = rows_of(test);
  observation.add = [&test](const Reference& reference, std::size_t g, Detail, OutputRows rows) {
    Felt felt;
    reference.felt(test.stretches[g].first + 0.5 * test.stretches[g].duration(), 1.0, std::span(&felt, 1));
    rows[0][0] += felt.rate.x;
  };
  const auto latitude = effects_named(effects_of(test, observation), names::latitude);
  ASSERT_EQ(latitude.size(), 1u);
  EXPECT_FALSE(latitude[0].key.empty());
  Plan north = plan;
  north.site->latitude += 1e-5;
  const auto moved = stretches(north, {.role = "gyro"});
  for (std::size_t g = 0; g < test.stretches.size(); ++g) {
    Felt before, after;
    const double middle = test.stretches[g].first + 0.5 * test.stretches[g].duration();
    test.power_ups[0].reference.felt(middle, 1.0, std::span(&before, 1));
    moved.power_ups[0].reference.felt(middle, 1.0, std::span(&after, 1));
    EXPECT_NEAR(latitude[0].column[g], after.rate.x - before.rate.x, 1e-18);
  }
}

/// Each output has its own sizes and its own segments that move it: together they must be what each is alone.
TEST(RigEffects, OutputsThatAreObservedTogetherHaveTheEffectsOfEachAlone) {
  const Plan plan = head_plan({held("a", 0.0), held("b", 0.5 * std::numbers::pi), held("c", std::numbers::pi)});
  const auto test = stretches(plan, {.role = "accelerometer"});
  const auto shown = [](std::size_t output, const Felt& felt) {
    return output == 0 ? felt.specific_force.x : output == 1 ? felt.specific_force.y : 1e3 * felt.rate.y;
  };
  const auto observed = [&](std::vector<std::size_t> outputs) {
    Observation observation = rows_of(test);
    observation.outputs = outputs.size();
    observation.add = [&test, shown, outputs](const Reference& reference, std::size_t g, Detail, OutputRows rows) {
      Felt felt;
      reference.felt(test.stretches[g].first + 0.5 * test.stretches[g].duration(), 1.0, std::span(&felt, 1));
      for (std::size_t k = 0; k < outputs.size(); ++k)
        for (double& row : rows[k]) row += shown(outputs[k], felt);
    };
    return rig_effects(test, observation);
  };
  const auto together = observed({0, 1, 2});
  ASSERT_EQ(together.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto alone = observed({k}).at(0);
    ASSERT_EQ(together[k].size(), alone.size()) << k;
    EXPECT_GT(alone.size(), 3u);
    for (std::size_t e = 0; e < alone.size(); ++e) {
      EXPECT_EQ(together[k][e].source, alone[e].source);
      EXPECT_EQ(together[k][e].column, alone[e].column);
      EXPECT_EQ(together[k][e].draws, alone[e].draws);
      EXPECT_EQ(together[k][e].key, alone[e].key);
      EXPECT_EQ(together[k][e].each_segment, alone[e].each_segment);
    }
  }
}

}  // namespace
}  // namespace tumble
