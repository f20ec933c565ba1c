// Plans with several power-ups: each begins where its first segment wants the axes, with a unit that was off there.
#include <gtest/gtest.h>

#include <algorithm>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using testing::bench_segment;
using testing::bench_station;
using testing::ExecutiveBench;
using testing::warm_to;

constexpr double off_time = 600.0, soak = 60.0;  // [s]

std::shared_ptr<const Course> two_power_ups(bool supply) {
  Course course{.station = bench_station(supply),
                .schedule = {bench_segment("cold", 100.0, {{"chamber", warm_to(-20.0)}}, 1),
                             bench_segment("hot", 100.0, {{"chamber", warm_to(60.0)}}, 2)}};
  course.station.power.off_time = off_time;
  course.units = {{"1", "A"}};
  course.prompt_deadline = 7200.0;
  return std::make_shared<const Course>(std::move(course));
}

std::vector<double> times_of(const ExecutiveBench& bench, ControllerVerb verb, const std::string& device) {
  std::vector<double> times;
  for (const auto& one : bench.asked)
    if (one.ask.request.verb == verb && one.ask.device == device) times.push_back(one.time);
  return times;
}

TEST(ExecutivePowerUps, BeginWhereTheFirstSegmentIsRecorded) {
  ExecutiveBench bench(two_power_ups(true));
  ASSERT_EQ(bench.run(2e4), RunEnding::complete);
  const auto off = times_of(bench, ControllerVerb::off, "supply"),
             on = times_of(bench, ControllerVerb::start, "supply"),
             set = times_of(bench, ControllerVerb::set_temperature, "climate");
  ASSERT_EQ(on.size(), 2u);
  ASSERT_GE(off.size(), 2u);
  ASSERT_EQ(set.size(), 2u);
  for (std::size_t run = 0; run < 2; ++run) {
    EXPECT_LT(off[run], set[run]) << "the unit is off while the chamber goes there";
    EXPECT_LT(bench.recorded[run].begin - on[run], 0.01) << "the recording begins with the power-up";
    EXPECT_GE(on[run] - set[run], soak + off_time) << "it has soaked at this temperature";
  }
}

TEST(ExecutivePowerUps, AreRepeatedWithTheirFirstSegment) {
  const auto course = two_power_ups(true);
  ExecutiveBench whole(course);
  ASSERT_EQ(whole.run(2e4), RunEnding::complete);
  ExecutiveBench bench(course);
  bench.at(whole.recorded[0].begin + 50.0, RunOrder{RunOrder::Kind::pause, "operator"});
  bench.at(whole.recorded[0].begin + 60.0, RunOrder{RunOrder::Kind::resume, "operator"});
  ASSERT_EQ(bench.run(2e4), RunEnding::complete);
  ASSERT_EQ(bench.recorded.size(), 3u);
  const auto on = times_of(bench, ControllerVerb::start, "supply");
  ASSERT_EQ(on.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(bench.recorded[k].begin - on[k], 0.01) << k;
  EXPECT_GE(on[1] - bench.recorded[0].end, off_time);
}

TEST(ExecutivePowerUps, APersonIsAskedWhenTheAxesAreThere) {
  ExecutiveBench bench(two_power_ups(false));
  bench.answering = [](const Prompt&) { return std::pair(700.0, std::string("done")); };
  ASSERT_EQ(bench.run(2e4), RunEnding::complete);
  ASSERT_EQ(bench.prompts.size(), 1u);
  const auto set = times_of(bench, ControllerVerb::set_temperature, "climate");
  ASSERT_EQ(set.size(), 2u);
  EXPECT_GT(bench.recorded[1].begin - set[1], soak + 700.0);
  const auto up = std::ranges::find_if(
      bench.rows, [](const RunRow& row) { return row.kind == RunRow::Kind::power_up && row.run == 2; });
  ASSERT_NE(up, bench.rows.end());
  EXPECT_NEAR(bench.recorded[1].begin, up->time, 5.0 * bench.reply_after);
}

}  // namespace
}  // namespace tumble
