// Set points of chambers: read back after they were acknowledged, and not faster than the station allows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using testing::asked_for;
using testing::bench_segment;
using testing::bench_station;
using testing::BenchFault;
using testing::ExecutiveBench;

constexpr std::size_t chamber_device = 1;  ///< device of the chamber

/// One dwell of 60 s at this temperature, at a chamber that reads its set point back.
std::shared_ptr<Course> dwell_at(double temperature) {
  auto course = std::make_shared<Course>();
  course->station = bench_station();
  course->station.devices[chamber_device].verbs.push_back(ControllerVerb::set_point);
  course->station.devices[chamber_device].set_point_verb = ControllerVerb::set_point;
  course->station.devices[chamber_device].set_point_step = 0.05;
  course->schedule = {bench_segment("warm", 60.0, {{"chamber", {.kind = Motion::Kind::dwell, .value = temperature}}})};
  course->units = {{"1", "S1"}};
  return course;
}

TEST(SetPoint, IsReadBackBeforeTheRunGoesOn) {
  ExecutiveBench bench(dwell_at(si(40.0, "degC")));
  EXPECT_EQ(bench.run(1e5), RunEnding::complete);
  const auto set = asked_for(bench, ControllerVerb::set_temperature),
             read = asked_for(bench, ControllerVerb::set_point);
  ASSERT_EQ(set.size(), 1u);
  ASSERT_EQ(read.size(), 1u) << "once confirmed, it is not asked for again";
  EXPECT_GT(read[0].time, set[0].time);
  EXPECT_GT(bench.phase_began.at("settling"), read[0].time);
}

TEST(SetPoint, ThatIsAcknowledgedAndIgnoredFailsTheAttempt) {
  ExecutiveBench bench(dwell_at(si(40.0, "degC")));
  bench.fault({.kind = BenchFault::Kind::ignores, .device = "climate"});
  bench.answering = [](const Prompt&) { return std::pair{1.0, std::string("stop")}; };
  EXPECT_EQ(bench.run(1e5), RunEnding::stopped);
  ASSERT_EQ(bench.prompts.size(), 1u);
  EXPECT_EQ(bench.prompts[0].text,
            "Segment 'warm': climate has acknowledged a set point of 40 degC, and reads back 20 degC");
  EXPECT_LT(bench.ended_at, 60.0) << "it is known long before the chamber should have settled";
}

/// A safe list that brings the chamber to room temperature.
std::shared_ptr<Course> with_safe_set_point() {
  auto course = dwell_at(si(40.0, "degC"));
  course->station.safe[1].request = {ControllerVerb::set_temperature, {{"temperature", si(23.0, "degC")}}};
  return course;
}

TEST(SetPoint, OfTheSafeListIsConfirmedByReadingItBack) {
  ExecutiveBench bench(with_safe_set_point());
  bench.at(100.0, RunOrder{RunOrder::Kind::stop, "operator"});
  EXPECT_EQ(bench.run(1e5), RunEnding::stopped);
  EXPECT_GT(asked_for(bench, ControllerVerb::set_point).back().time, 100.0);
  EXPECT_LT(bench.ended_at, 105.0);
}

TEST(SetPoint, OfTheSafeListThatIsIgnoredIsFaulted) {
  ExecutiveBench bench(with_safe_set_point());
  bench.fault({.kind = BenchFault::Kind::ignores, .device = "climate", .from = 90.0});
  bench.at(100.0, RunOrder{RunOrder::Kind::stop, "operator"});
  EXPECT_EQ(bench.run(1e5), RunEnding::faulted);
  EXPECT_NEAR(bench.ended_at, 100.0 + bench.state.course->station.safe[1].within, 0.5);
  EXPECT_NE(bench.ended->text.text().find("climate: 'set_temperature' was not confirmed"), std::string::npos)
      << bench.ended->text.text();
}

TEST(SetPoint, DoesNotGoFasterThanTheStationAllows) {
  auto course = dwell_at(si(40.0, "degC"));
  StationAxis& chamber = course->station.axes[1];
  chamber.max_rate = si(2.0, "K/min");
  chamber.ramp_step = 15.0;
  ExecutiveBench bench(course);
  EXPECT_EQ(bench.run(1e5), RunEnding::complete);
  const auto set = asked_for(bench, ControllerVerb::set_temperature);
  ASSERT_EQ(set.size(), 40u) << "20 K at 2 K/min, a step each 15 s";
  double before = si(20.0, "degC"), sent = set[0].time - chamber.ramp_step;
  for (const auto& one : set) {
    const double point = one.ask.request.values.at("temperature");
    EXPECT_LE(point - before, *chamber.max_rate * (one.time - sent) * 1.01 + 1e-9);
    before = point;
    sent = one.time;
  }
  EXPECT_DOUBLE_EQ(before, si(40.0, "degC"));
}

TEST(SetPoint, OfAPlanThatRampsFasterIsRefused) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/fog_thermal_bias.toml", {});
  Station station = load_station(TUMBLE_SOURCE_DIR "/stations/fog_thermal_bias.toml");
  const auto chamber = std::ranges::find(station.axes, StationAxis::Kind::temperature, &StationAxis::kind);
  ASSERT_NE(chamber, station.axes.end());
  chamber->max_rate = si(0.01, "K/min");
  EXPECT_TRUE(has_problem(check_station(plan, station, {.rehearsed = true}),
                          {.values = {"K/min", "0.01", "K/min"}, .pattern = "is beyond the station's"}));
}

}  // namespace
}  // namespace tumble
