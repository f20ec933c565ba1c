// Motions that nobody has commanded, conditions that are not met while the rig moves, and rows that are not on the
// disk.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using testing::asked_for;
using testing::bench_course;
using testing::bench_segment;
using testing::bench_station;
using testing::BenchFault;
using testing::ExecutiveBench;
using testing::hold_at;
using testing::rows_of_kind;
using testing::turn_at;
using Fault = BenchFault::Kind;

Station station_that_holds() {
  Station station = bench_station();
  station.interlocks.push_back({.require = parse_requirement("lab.humidity < 60"),
                                .action = StationInterlock::Action::hold,
                                .debounce = 1.0,
                                .stale = 1e9});
  return station;
}

ChannelValues humid(double value) { return {{{"lab.humidity", value}}}; }

TEST(ExecutiveMotions, WhatTurnsIsStoppedWhileAConditionIsNotMet) {
  ExecutiveBench bench(bench_course({bench_segment("turns", 60.0, {{"table", turn_at(20.0)}})}, station_that_holds()));
  const double poll = bench.state.course->station.devices[0].poll;  // of the table
  bench.at(0.0, humid(50.0));
  bench.at(20.0, humid(70.0));
  bench.at(60.0, humid(50.0));
  bench.run(30.0);
  EXPECT_EQ(bench.state.phase, RunPhase::holding);
  EXPECT_NEAR(asked_for(bench, ControllerVerb::stop).at(0).time, 21.0, 2.0 * poll) << "when the debounce time is over";
  EXPECT_LE(std::abs(bench.true_rate("table")), 1e-4);
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  ASSERT_EQ(bench.recorded.size(), 2u);
  EXPECT_NEAR(bench.recorded[1].end - bench.recorded[1].begin, 60.0, 2.0 * poll) << "it is repeated as a whole";
}

/// The settling of an axis that turns cannot go on while it stands: it is another attempt.
TEST(ExecutiveMotions, WhatTurnsIsStoppedAlsoBeforeItIsRecorded) {
  Station station = station_that_holds();
  station.axes[0].settle.soak = 30.0;
  ExecutiveBench bench(bench_course({bench_segment("turns", 10.0, {{"table", turn_at(20.0)}})}, station));
  bench.at(0.0, humid(50.0));
  bench.at(15.0, humid(70.0));
  bench.at(40.0, humid(50.0));
  bench.run(30.0);
  EXPECT_LE(std::abs(bench.true_rate("table")), 1e-4);
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::segment_ends).size(), 2u);
}

TEST(ExecutiveMotions, ATableThatTurnsFasterThanItWasToldIsStoppedWithinSeconds) {
  for (const double size : {-2.0, 1.0, 7.0}) {  // the other way, twice and eight times as fast
    Station station = bench_station();
    station.axes[0].max_rate = 300.0 * degree;
    ExecutiveBench bench(bench_course({bench_segment("turns", 100.0, {{"table", turn_at(20.0)}})}, station));
    bench.fault({.kind = Fault::off_rate, .device = "servo", .from = 20.0, .size = size});
    ASSERT_EQ(bench.run(1000.0), RunEnding::stopped) << size;
    // It takes its brakes of 2 rad/s^2 1.5 s at most to turn so, it does so for a second, and two polls see it.
    EXPECT_LE(bench.state.decided, 20.0 + 1.5 + 1.0 + 0.3) << size;
    EXPECT_NE(bench.ended->text.text().find("table turns at"), std::string::npos) << bench.ended->text.text();
  }
}

TEST(ExecutiveMotions, ARateAboveThatOfTheStationStopsTheRunAtOnce) {
  Station station = bench_station();
  station.axes[0].max_rate = 30.0 * degree;
  ExecutiveBench bench(bench_course({bench_segment("turns", 100.0, {{"table", turn_at(20.0)}})}, station));
  bench.fault({.kind = Fault::off_rate, .device = "servo", .from = 20.0, .size = 0.7});
  ASSERT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_LE(bench.state.decided, 20.0 + 0.6) << "two readings, a tenth of a second apart, after the table has changed";
  EXPECT_NE(bench.ended->text.text().find("the station allows 30 deg/s"), std::string::npos)
      << bench.ended->text.text();
}

TEST(ExecutiveMotions, AccelerationIsNoMotionOfItsOwn) {
  Station station = bench_station();
  station.axes[0].max_rate = 120.0 * degree;
  Schedule schedule;
  for (const double rate : {120.0, -120.0, 5.0})
    schedule.push_back(bench_segment("turns", 5.0, {{"table", turn_at(rate)}}));
  schedule.push_back(bench_segment("stands", 5.0, {{"table", hold_at(10.0)}}));
  for (const bool reads_rate : {true, false}) {
    ExecutiveBench bench(bench_course(schedule, station));
    bench.reads_rate = reads_rate;
    EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  }
}

/// Rows are on the disk before what they precede is sent; readings and stops go on.
TEST(ExecutiveMotions, NothingMovesBeforeItsRowIsOnTheDisk) {
  ExecutiveBench bench(bench_course({bench_segment("turns", 10.0, {{"table", turn_at(20.0)}})}));
  bench.state.awaits_rows = true;
  bench.at(30.0, RowsStored{1});
  bench.at(60.0, RowsStored{2});
  bench.at(90.0, RowsStored{100});
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_GE(asked_for(bench, ControllerVerb::rate).at(0).time, 30.0);
  const auto reads = asked_for(bench, ControllerVerb::read);
  for (std::size_t i = 1; i < reads.size(); ++i) EXPECT_LT(reads[i].time - reads[i - 1].time, 1.5);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::segment_begins).size(), 1u) << "the disk takes no time of the attempt";
}

TEST(ExecutiveMotions, TheSafeListWaitsForNoRow) {
  ExecutiveBench bench(bench_course({bench_segment("turns", 10.0, {{"table", turn_at(20.0)}})}));
  bench.state.awaits_rows = true;
  bench.at(5.0, MustStop{"servo floods its link"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_EQ(asked_for(bench, ControllerVerb::stop).at(0).time, 5.0);
  EXPECT_TRUE(asked_for(bench, ControllerVerb::rate).empty());
  EXPECT_EQ(bench.ended->text, "servo floods its link");
}

}  // namespace
}  // namespace tumble
