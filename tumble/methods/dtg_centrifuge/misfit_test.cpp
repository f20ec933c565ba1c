#include "tumble/methods/dtg_centrifuge/misfit.hpp"

#include <gtest/gtest.h>

#include "tumble/reduce/testing/trial_plan.hpp"

namespace tumble::dtg_centrifuge {
namespace {

constexpr double radius_of_rig = 2.5;  // m
constexpr double planned = 2.0;        // rad/s

/// Findings on one level that is reduced with the lines of a rig at `nominal` rad/s, which it takes for `taken` rad/s,
/// and at which the encoder shows `recorded` rad/s.
Findings found(double nominal, double taken, double recorded, double radius_sd = 20e-6) {
  Plan plan = trial_plan("dtg_centrifuge", {}, "dynamically_tuned_gyro", "counter_rotating_centrifuge", 20.0);
  plan.rig.set_number("radius", radius_of_rig, Unit::parse("m"));
  plan.rig.set_number("radius_sd", radius_sd, Unit::parse("um"));
  Test test;
  test.power_ups.push_back({.plan = &plan});
  const Spin spin{.label = "spin 1", .arm_rate = planned};
  Measured measured;
  measured.stretch = &spin;
  measured.arm_rate = recorded;
  Reduction reduction;
  reduction.nominal.push_back({});
  reduction.nominal[0].force[0].line[0] = -nominal * nominal * radius_of_rig;
  reduction.nominal[0].arm_rate = taken;
  Findings findings;
  check_forces(test, {measured}, reduction, findings);
  return findings;
}

TEST(DtgForces, AreThoseOfTheRigAtTheRecordedRate) {
  EXPECT_TRUE(found(planned, planned, planned).empty());
  EXPECT_TRUE(found(planned, planned, 1.3 * planned).empty()) << "what was carried out decides, not the plan";
  const Findings wrong = found(planned, 0.9 * planned, planned);
  ASSERT_EQ(wrong.size(), 1u);
  EXPECT_EQ(wrong[0].code, "force_differs_from_rig");
  EXPECT_EQ(wrong[0].severity, Finding::Severity::error);
  EXPECT_EQ(wrong[0].occurrences.first.label, "run 1, spin 1");
}

TEST(DtgForces, MayDifferByTheStatedErrorsOfTheRig) {
  EXPECT_EQ(found(1.01 * planned, planned, planned).size(), 1u);
  EXPECT_TRUE(found(1.01 * planned, planned, planned, 0.01 * radius_of_rig).empty()) << "2 % of 6 x 1 %";
}

}  // namespace
}  // namespace tumble::dtg_centrifuge
