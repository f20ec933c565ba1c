// What an axis is told of the limits of its station, what counts as a reading of it, and what stops it.
#include <gtest/gtest.h>

#include <algorithm>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using testing::bench_course;
using testing::bench_segment;
using testing::bench_station;
using testing::BenchFault;
using testing::ExecutiveBench;
using testing::warm_to;

Schedule turning(double degrees_a_second, double duration) {
  return {bench_segment("turning", duration,
                        {{"table", {.kind = Motion::Kind::rate, .value = si(degrees_a_second, "deg/s")}}})};
}

std::vector<ControllerRequest> requests_of(const ExecutiveBench& bench, ControllerVerb verb) {
  std::vector<ControllerRequest> requests;
  for (const auto& one : bench.asked)
    if (one.ask.request.verb == verb) requests.push_back(one.ask.request);
  return requests;
}

TEST(ExecutiveLimits, TheAccelerationOfTheStationGoesWithTheCommandsThatCarryIt) {
  Station station = bench_station();
  station.axes[0].max_acceleration = si(5.0, "deg/s^2");
  station.devices[0].takes = {{ControllerVerb::rate, {"acceleration", "rate"}},
                              {ControllerVerb::position, {"position", "rate"}}};
  Schedule schedule = turning(20.0, 5.0);
  schedule.push_back(bench_segment("held", 5.0, {{"table", {.value = 0.0}}}));
  ExecutiveBench bench(bench_course(schedule, station));
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(requests_of(bench, ControllerVerb::rate).at(0).values.at("acceleration"), si(5.0, "deg/s^2"));
  EXPECT_FALSE(requests_of(bench, ControllerVerb::position).at(0).values.contains("acceleration"))
      << "the verb does not carry it";
}

TEST(ExecutiveLimits, AnAxisThatRunsOutOfItsTravelIsStopped) {
  Station station = bench_station();
  station.axes[0].highest = si(90.0, "deg");
  station.axes[0].lowest = si(-90.0, "deg");
  ExecutiveBench bench(bench_course(turning(20.0, 60.0), station));
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  // 1.8 deg beyond, two readings of 0.1 s, and the way of the brakes: 20 deg/s at 2 rad/s^2 take 1.8 deg
  EXPECT_LT(bench.true_position("table"), si(90.0 + 1.8 + 20.0 * 0.3 + 2.0, "deg"));
  EXPECT_NE(bench.ended->text.text().find("table has left its travel"), std::string::npos) << bench.ended->text.text();
}

TEST(ExecutiveLimits, AnAxisOutsideOfItsTravelMayComeBack) {
  Station station = bench_station();  // its offset is 0.3 rad: there the table stands
  station.axes[0].highest = si(-5.0, "deg");
  station.axes[0].lowest = si(-90.0, "deg");
  ExecutiveBench bench(bench_course({bench_segment("back", 5.0, {{"table", {.value = si(-45.0, "deg")}}})}, station));
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete) << bench.ended->text.text();
}

TEST(ExecutiveLimits, AlarmsOfADeviceAreAskedForAndStopTheRun) {
  Station station = bench_station();
  station.devices[1].verbs.push_back(ControllerVerb::alarm);
  Schedule schedule{bench_segment("warm", 300.0, {{"chamber", {.kind = Motion::Kind::dwell, .value = 293.15}}})};
  ExecutiveBench bench(bench_course(schedule, station));
  ControllerReply alarm{ControllerVerb::alarm};
  bench.run(100.0);
  ASSERT_FALSE(requests_of(bench, ControllerVerb::alarm).empty());
  const auto step_with_alarm = [&](const std::string& word) {
    ControllerReply reply{ControllerVerb::alarm};
    reply.words = {{"alarm", word}};
    auto state = bench.state;
    const std::size_t climate = 1;
    state.devices[climate].asked = PendingRequest{{ControllerVerb::alarm}, PendingRequest::Purpose::poll, 1};
    std::vector<RunAction> actions;
    return step(state, {bench.state.now, DeviceReply{"climate", reply}}, actions).phase;
  };
  EXPECT_EQ(step_with_alarm("alarm"), RunPhase::stopping);
  EXPECT_EQ(step_with_alarm("none"), bench.state.phase);
}

/// The reply to a command repeats its value: the chamber is not there yet.
TEST(ExecutiveLimits, TheEchoOfACommandIsNoReading) {
  ExecutiveBench bench(bench_course({bench_segment("hot", 60.0, {{"chamber", warm_to(60.0)}})}));
  bench.run(10.0);
  auto state = bench.state;
  const auto before = state.axes[1].temperature;
  ASSERT_TRUE(before && *before < 330.0);
  ControllerReply echo{ControllerVerb::set_temperature};
  echo.values = {{"temperature", 333.15}};
  state.devices[1].asked =
      PendingRequest{{ControllerVerb::set_temperature, {{"temperature", 333.15}}}, PendingRequest::Purpose::motion, 1};
  std::vector<RunAction> actions;
  state = step(state, {state.now, DeviceReply{"climate", echo}}, actions);
  EXPECT_EQ(state.axes[1].temperature, before);
  EXPECT_EQ(std::get<double>(state.channels.at("chamber.temperature").value), *before);
}

TEST(ExecutiveLimits, AStateThatIsANumberIsNoReadingOfARate) {
  ExecutiveBench bench(bench_course(turning(20.0, 60.0)));
  bench.run(0.5);
  auto state = bench.state;
  state.axes[0].rate = 0.0;
  state.axes[0].at_rest = 1;
  ControllerReply number{ControllerVerb::state};
  number.values = {{"motion", 1.0}};
  state.devices[0].asked = PendingRequest{{ControllerVerb::state}, PendingRequest::Purpose::poll, 1};
  std::vector<RunAction> actions;
  EXPECT_EQ(step(state, {state.now, DeviceReply{"servo", number}}, actions).axes[0].at_rest, 1);
}

TEST(ExecutiveLimits, TheUnitOfAResumedRunTakesPartAgainWhereNoneWasLeft) {
  Course course{.station = bench_station(), .schedule = turning(20.0, 5.0)};
  course.units = {{"1", "A"}, {"2", "B"}};
  const auto shared = std::make_shared<const Course>(course);
  const auto out = [](const std::string& slot) { return RunRow{.kind = RunRow::Kind::unit_out, .label = slot}; };
  EXPECT_EQ(resume_state(shared, {out("1")}).units_out, std::vector<std::string>{"1"});
  EXPECT_TRUE(resume_state(shared, {out("1"), out("2")}).units_out.empty());
}

}  // namespace
}  // namespace tumble
