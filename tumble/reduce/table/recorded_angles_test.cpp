#include "tumble/reduce/table/recorded_angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/reduce/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::table {
namespace {

constexpr double arcsec = std::numbers::pi / 648000.0;

/// Three positions and ten turns on a table whose angles are off by what it likes.
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
  for (const auto& one : angles.stands)
    if (one.label == label && one.axis == axis) return one;
  throw std::runtime_error(label);
}

TEST(RecordedAngles, replace_what_the_plan_commands) {
  const auto angles = with_recorded_angles(recorded(60.0 * arcsec), 2.0, si(0.1, "deg"));
  ASSERT_EQ(angles.axes.size(), 2u);
  const auto& schedule = angles.evidence.plan.schedule;
  const auto& b = stand(angles, "b", "outer");
  EXPECT_NE(b.recorded, b.commanded);
  EXPECT_EQ(schedule[1].axes.at("outer").value, b.recorded);
  EXPECT_EQ(schedule[2].axes.at("inner").to, stand(angles, "turns", "inner").recorded);
  // a step of 0.36 arcsec is left in the mean as its variance over 12, and 0.1 arcsec of noise over some 50 readings
  EXPECT_NEAR(b.sd, std::hypot(0.36 / std::sqrt(12.0), 0.1 / std::sqrt(50.0)) * arcsec, 0.02 * arcsec);
  EXPECT_LT(angles.evidence.plan.rig.number("repeatability_sd"), 0.2 * arcsec);
  EXPECT_TRUE(angles.findings.empty());
  EXPECT_EQ(angles_table(angles).rows.size(), angles.stands.size());
}

TEST(RecordedAngles, readings_within_one_turn_are_taken_nearest_to_the_plan) {
  Evidence evidence = recorded(0.0);
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "inner_angle")
      for (double& v : channel.values) v -= 2.0 * std::numbers::pi * std::floor(v / (2.0 * std::numbers::pi));
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  EXPECT_NEAR(stand(angles, "turns", "inner").recorded, si(3600.0, "deg"), 0.5 * arcsec);
  EXPECT_NEAR(stand(angles, "a", "inner").recorded, 0.0, 0.5 * arcsec);
}

TEST(RecordedAngles, far_from_the_plan_and_not_at_rest_are_said) {
  Evidence evidence = recorded(0.0);
  for (auto& channel : evidence.recordings[0].channels)
    if (channel.name == "outer_angle")
      for (std::size_t i = 60; i < 120; ++i) channel.values[i] += si(1.0, "deg") + static_cast<double>(i) * arcsec;
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  ASSERT_EQ(angles.findings.size(), 2u);
  EXPECT_NE(angles.findings[0].message.find("did not come to rest"), std::string::npos);
  EXPECT_NE(angles.findings[1].message.find("'b' (outer at 91.0"), std::string::npos) << angles.findings[1].message;
}

TEST(RecordedAngles, a_turn_at_another_time_is_said) {
  Evidence evidence = recorded(0.0);
  for (auto& segment : evidence.plan.schedule)
    if (segment.label == "turns") segment.axes.at("inner").value = si(18.5, "deg/s");
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  ASSERT_EQ(angles.findings.size(), 1u);
  // half of 3600 deg at 20 instead of 18.5 deg/s is 7.3 s early, seen to a sample
  EXPECT_NE(angles.findings[0].message.find("'turns' (6.8"), std::string::npos) << angles.findings[0].message;
}

// Before, the last reading of a recording cut short stood for every slew that follows.
TEST(RecordedAngles, nothing_is_said_of_what_a_recording_cut_short_lacks) {
  Evidence evidence = recorded(0.0);
  for (auto& channel : evidence.recordings[0].channels) channel.values.resize(100);  // in b
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  EXPECT_TRUE(angles.findings.empty()) << angles.findings.front().message;
  for (const auto& one : angles.stands) EXPECT_TRUE(one.label == "a" || one.label == "b") << one.label;
}

TEST(RecordedAngles, without_encoders_nothing_changes) {
  Evidence evidence = recorded(0.0);
  std::erase_if(evidence.recordings[0].channels, [](const Channel& c) { return c.kind == QuantityKind::angle; });
  const auto angles = with_recorded_angles(evidence, 2.0, si(0.1, "deg"));
  EXPECT_TRUE(angles.stands.empty());
  EXPECT_EQ(angles.evidence.plan.rig.texts(), evidence.plan.rig.texts());
}

}  // namespace
}  // namespace tumble::table
