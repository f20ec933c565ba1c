#include "tumble/reduce/table/recorded_angles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::table {
namespace {

constexpr double arcsec = std::numbers::pi / 648000.0;

/// Three positions and ten turns on a table with this repeatability [arcsec].
Evidence recorded(double repeatability) {
  Plan plan = trial_plan("rlg_north_finder", {}, "ring_laser_gyro", "two_axis_table", 1.0);
  plan.rig.set_number("repeatability_sd", repeatability, Unit::parse("arcsec"));
  const auto hold = [](double degrees) { return Motion{.value = si(degrees, "deg")}; };
  plan.schedule = {{"a", 60.0, 1, {{"outer", hold(0)}, {"inner", hold(0)}}},
                   {"b", 60.0, 1, {{"outer", hold(90)}}},
                   {"turns",
                    200.0,
                    1,
                    {{"inner", {.kind = Motion::Kind::slew, .value = si(20.0, "deg/s"), .to = si(3600.0, "deg")}}}},
                   {"c", 60.0, 1, {{"inner", hold(3690)}}}};
  Evidence evidence;
  evidence.plan = plan;
  evidence.recordings = {simulate(plan, 3, {})};
  return evidence;
}

const Stand& stand(const RecordedAngles& angles, const char* label, const char* axis) {
  for (const auto& stand : angles.stands)
    if (stand.label == label && stand.axis == axis) return stand;
  throw std::runtime_error(label);
}

/// A value [SI] of a finding of this code.
double value_of(const Finding& finding, const char* code, const char* name) {
  EXPECT_EQ(finding.code, code);
  const auto value = std::ranges::find(finding.values, name, &FindingValue::name);
  return value == finding.values.end() ? std::nan("") : std::get<double>(value->value);
}

TEST(RecordedAngles, ReplaceWhatThePlanCommands) {
  const auto angles = with_recorded_angles(recorded(60.0 * arcsec), 2.0, si(0.1, "deg"));
  ASSERT_EQ(angles.axes.size(), 2u);
  const auto& schedule = angles.evidence.plan.schedule;
  const auto& b = stand(angles, "b", "outer");
  EXPECT_NE(b.recorded, b.commanded);
  EXPECT_EQ(schedule[1].axes.at("outer").value, b.recorded);
  EXPECT_EQ(schedule[2].axes.at("inner").to, stand(angles, "turns", "inner").recorded);
  // a step of 0.36 arcsec remains in the mean as its variance over 12, and 0.1 arcsec of noise over some 50 readings
  EXPECT_NEAR(b.sd, std::hypot(0.36 / std::sqrt(12.0), 0.1 / std::sqrt(50.0)) * arcsec, 0.02 * arcsec);
  EXPECT_LT(angles.evidence.plan.rig.number("repeatability_sd"), 0.2 * arcsec);
  EXPECT_TRUE(angles.findings.empty());
  EXPECT_EQ(angles_table(angles).rows.size(), angles.stands.size());
}

TEST(RecordedAngles, ReadingsWithinOneTurnAreTakenNearestToThePlan) {
  Evidence evidence = recorded(0.0);
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "inner_angle")
      for (double& v : channel.values) v -= 2.0 * std::numbers::pi * std::floor(v / (2.0 * std::numbers::pi));
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  EXPECT_NEAR(stand(angles, "turns", "inner").recorded, si(3600.0, "deg"), 0.5 * arcsec);
  EXPECT_NEAR(stand(angles, "a", "inner").recorded, 0.0, 0.5 * arcsec);
}

TEST(RecordedAngles, FarFromThePlanAndNotAtRestAreSaid) {
  Evidence evidence = recorded(0.0);
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "outer_angle")
      for (std::size_t i = 60; i < 120; ++i) channel.values[i] += si(1.0, "deg") + static_cast<double>(i) * arcsec;
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  ASSERT_EQ(angles.findings.size(), 2u);
  EXPECT_EQ(angles.findings[0].code, "axis_not_at_rest");
  EXPECT_EQ(angles.findings[0].where, "b");
  // 1 deg, and the mean of 62 to 119 arcsec
  EXPECT_NEAR(value_of(angles.findings[1], "angle_off_plan", "recorded"), si(91.0, "deg"), 120.0 * arcsec);
}

TEST(RecordedAngles, ATurnAtAnotherTimeIsSaid) {
  Evidence evidence = recorded(0.0);
  for (auto& segment : evidence.plan.schedule)
    if (segment.label == "turns") segment.axes.at("inner").value = si(18.5, "deg/s");
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  ASSERT_EQ(angles.findings.size(), 1u);
  // half of 3600 deg at 20 instead of 18.5 deg/s is 7.3 s early, seen to a sample of 1 s
  EXPECT_NEAR(value_of(angles.findings[0], "turn_early", "offset"), 7.3, 1.0);
  EXPECT_EQ(angles.findings[0].where, "turns");
}

// Before, the last reading of a shortened recording was the angle of every slew that follows.
TEST(RecordedAngles, NothingIsSaidOfWhatARecordingCutShortLacks) {
  Evidence evidence = recorded(0.0);
  for (auto& channel : evidence.recordings[0].channels) channel.values.resize(100);  // in b
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  EXPECT_TRUE(angles.findings.empty()) << angles.findings.front().message;
  for (const auto& stand : angles.stands) EXPECT_TRUE(stand.label == "a" || stand.label == "b") << stand.label;
}

/// Seconds as samples, and marks half a second later: the last sample of a position holds a part of the move to the
/// next.
TEST(RecordedAngles, AReadingThatReachesIntoTheNextSegmentIsNotOfThisOne) {
  Evidence evidence = recorded(1e-6);
  for (auto& mark : evidence.recordings[0].marks) mark.begin += mark.begin > 0.0 ? 0.5 : 0.0;
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "outer_angle") channel.values[60] = si(45.0, "deg");  // the reading from 60 s to 61 s
  evidence.plan.schedule[0].duration = 60.5;
  const auto angles = with_recorded_angles(evidence, 1.0, si(1.0, "arcsec"));
  EXPECT_NEAR(stand(angles, "a", "outer").recorded, 0.0, si(1.0, "arcsec"));
}

TEST(RecordedAngles, WithoutEncodersNothingChanges) {
  Evidence evidence = recorded(0.0);
  std::erase_if(evidence.recordings[0].channels, [](const Channel& c) { return c.kind == QuantityKind::angle; });
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  EXPECT_TRUE(angles.stands.empty());
  EXPECT_EQ(angles.evidence.plan.rig.texts(), evidence.plan.rig.texts());
}

// An encoder whose number of lines is stated wrongly by one of 36 000: 0.1 deg and 100 arcsec over ten turns are beyond any
// repeatability, and below the tolerance.
TEST(RecordedAngles, AnEncoderWithAGainIsSaid) {
  EXPECT_TRUE(with_recorded_angles(recorded(1.0 * arcsec), 2.0, si(0.2, "deg")).findings.empty());
  Evidence evidence = recorded(1.0 * arcsec);
  Plan& plan = evidence.plan;
  plan.schedule.push_back({"d", 60.0, 1, {{"inner", Motion{.value = si(3780, "deg")}}}});
  plan.schedule.push_back({"e", 60.0, 1, {{"inner", Motion{.value = si(3600, "deg")}}}});
  evidence.recordings = {simulate(plan, 3, {})};
  EXPECT_TRUE(with_recorded_angles(evidence, 2.0, si(0.2, "deg")).findings.empty());
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "inner_angle")
      for (double& v : channel.values) v *= 1.0 + 1.0 / 36000.0;
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.2, "deg"));
  ASSERT_EQ(angles.findings.size(), 1u);
  // 1 arcsec of repeatability over the 64 rad between the rests: four sd
  EXPECT_NEAR(value_of(angles.findings[0], "angles_off_in_proportion", "gain"), 1.0 / 36000.0, 3e-7);
  EXPECT_NEAR(value_of(angles.findings[0], "angles_off_in_proportion", "span"), si(3780, "deg"), 1e-9);
}

// The segment of the turns does not mention the outer axis, which stands where it was left.
TEST(RecordedAngles, AnAxisThatASegmentDoesNotMentionStandsWhereItIs) {
  Evidence evidence = recorded(1.0 * arcsec);
  Plan carried_out = evidence.plan;
  carried_out.schedule[1].axes.at("outer").value = si(45, "deg");
  evidence.recordings = {simulate(carried_out, 3, {})};
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  const auto& turns = angles.evidence.plan.schedule[2];
  EXPECT_NEAR(turns.axes.at("outer").value, si(45, "deg"), 5.0 * arcsec);
  EXPECT_NEAR(angles.evidence.plan.schedule[3].axes.at("outer").value, si(45, "deg"), 5.0 * arcsec);
  EXPECT_FALSE(
      with_recorded_angles(recorded(0.0), 2.0, si(0.1, "deg")).evidence.plan.schedule[2].axes.contains("outer"));
}

}  // namespace
}  // namespace tumble::table
