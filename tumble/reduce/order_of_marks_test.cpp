#include "tumble/reduce/order_of_marks.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

Segment at_table(const char* label, double degrees) {
  return {label, 30.0, 1, {{"table", {.value = degrees * degree}}}};
}

/// A rate table that needs 1 s for 10 deg and starts at once.
Plan plan_of_positions() {
  Plan plan;
  plan.rig_kind = "rate_table";
  plan.rig = defaults(find_rig("rate_table").options());
  plan.rig.set_number("max_rate", 10.0 * degree, Unit::parse("deg/s"));
  plan.site = Site{.latitude = 0.6};
  plan.sample_rate = 10.0;
  plan.schedule = {at_table("a", 0.0), at_table("b", 10.0), at_table("c", 180.0), at_table("d", 190.0)};
  plan.schedule[0].axes["mount_pitch"] = {.value = -90.0 * degree};
  return plan;
}

Evidence recorded(const Plan& plan, const std::vector<std::string>& labels, double pause = 0.0) {
  Recording recording;
  recording.channels = {{"gyro", QuantityKind::angular_rate, Unit::parse("rad/s"), {0.0, 10.0, nullptr}, {}}};
  double now = 0.0;
  for (const auto& label : labels) {
    recording.marks.push_back({label, now});
    now += 30.0 + pause;
  }
  recording.channels[0].values.assign(static_cast<std::size_t>(now * 10.0), 0.0);
  return {plan, {recording}};
}

std::optional<CarriedOut> order_in(const Evidence& evidence) {
  return in_order_of_marks(evidence.plan, marked_segments(evidence).at(0));
}

TEST(OrderOfMarks, APlanThatWasFollowedStays) {
  EXPECT_FALSE(order_in(recorded(plan_of_positions(), {"a", "b", "c", "d"})));
  EXPECT_FALSE(order_in(recorded(plan_of_positions(), {"c", "d"}))) << "the first ones were not recorded";
  EXPECT_FALSE(order_in(recorded(plan_of_positions(), {"a", "d"}, 70.0))) << "there was time for the others";
}

TEST(OrderOfMarks, AnotherOrderIsThatOfTheMarks) {
  const auto order = order_in(recorded(plan_of_positions(), {"c", "a", "b", "d"}));
  ASSERT_TRUE(order);
  EXPECT_EQ(order->planned, (std::vector<std::size_t>{2, 0, 1, 3}));
  EXPECT_EQ(order->schedule[0].axes.at("mount_pitch").value, -90.0 * degree)
      << "the fixture is mounted before the test";
}

TEST(OrderOfMarks, ASegmentThatWasPassedOverWasNotCarriedOut) {
  const auto order = order_in(recorded(plan_of_positions(), {"a", "c", "d"}));
  ASSERT_TRUE(order);
  EXPECT_EQ(order->planned, (std::vector<std::size_t>{0, 2, 3}));
}

TEST(OrderOfMarks, MovesTakeAsLongAsFromWhereTheAxisStood) {
  const Plan plan = plan_of_positions();
  const auto settled = [&](const std::vector<std::string>& labels) {
    const Evidence evidence = recorded(plan, labels);
    return settled_after(conducted(evidence.plan, marked_segments(evidence).at(0), false, 10.0));
  };
  const auto planned = settled({"a", "b", "c", "d"}), other = settled({"a", "d", "c", "b"});
  EXPECT_LT(planned[3], 2.0) << "10 deg";
  EXPECT_GT(other[3], 18.0) << "190 deg at 10 deg/s";
  EXPECT_GT(other[1], 16.0) << "170 deg";
  const auto test = stretches(recorded(plan, {"a", "d", "c", "b"}), {.role = "gyro", .needs_site = true});
  ASSERT_EQ(test.stretches.size(), 4u);
  EXPECT_NEAR(test.stretches[1].begin, 30.0 + other[3], 1e-9);
}

}  // namespace
}  // namespace tumble
