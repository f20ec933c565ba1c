// Links that are lost, silent or late, and what is sent again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using testing::asked_for;
using testing::bench_course;
using testing::bench_station;
using testing::BenchFault;
using testing::ExecutiveBench;
using testing::table_schedule;
using Fault = BenchFault::Kind;

// Point 28: a cable is pulled, in three ways.
TEST(Executive, BecomesSafeOnTheOtherLinksAtOnceWhenALinkIsLost) {
  for (const auto kind : {Fault::cut, Fault::silent}) {
    ExecutiveBench bench(bench_course(table_schedule()));
    bench.fault({.kind = kind, .device = "climate", .from = 10.03});
    EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);  // nobody knows of the chamber
    const double decided = bench.phase_began.at("stopping");
    EXPECT_LE(decided, 10.03 + (kind == Fault::cut ? 1e-9 : 10.0 + 1e-9));
    const auto stop = std::find_if(bench.asked.begin(), bench.asked.end(), [](const auto& one) {
      return one.ask.request.verb == ControllerVerb::stop && one.ask.urgent;
    });
    ASSERT_NE(stop, bench.asked.end());
    EXPECT_LE(stop->time - decided, 0.1);
    EXPECT_TRUE(bench.faults_of_order.empty());
    EXPECT_EQ(bench.true_rate("table"), 0.0);
    EXPECT_NE(bench.ended->text.text().find("climate: 'hold' was not confirmed"), std::string::npos)
        << bench.ended->text.text();
  }
}

TEST(Executive, DecidesThatATableIsLostAfterTheDeclaredSilence) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::silent, .device = "servo", .from = 10.0});
  EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);
  EXPECT_LE(bench.phase_began.at("stopping"), 10.0 + bench.reply_after + 0.5 + 1e-9);
  EXPECT_GE(bench.phase_began.at("stopping"), 10.0 + 0.5 - 0.1 - 0.01);
  EXPECT_NE(bench.ended->text.text().find("emergency stop of servo"), std::string::npos) << bench.ended->text.text();
}

TEST(Executive, SendsTheStopOnASilentLinkTooBecauseItMayArrive) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::deaf_reply, .device = "servo", .from = 20.0});
  EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);
  EXPECT_EQ(bench.true_rate("table"), 0.0);
  ExecutiveBench late(bench_course(table_schedule()));
  late.fault({.kind = Fault::deaf_reply, .device = "servo", .from = 20.0, .until = 22.0});
  EXPECT_EQ(late.run(1000.0), RunEnding::stopped);  // confirmed as soon as it answers again
  EXPECT_LT(late.ended_at, 23.0);
}

TEST(Executive, TakesATableThatStopsByItselfForSafe) {
  Station station = bench_station();
  station.devices[0].stops_by_itself = 1.0;
  ExecutiveBench bench(bench_course(table_schedule(), station));
  bench.fault({.kind = Fault::silent, .device = "servo", .from = 10.0});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_LE(bench.ended_at, 10.0 + bench.reply_after + 0.5 + 1.0 + 1e-9);
}

TEST(Executive, StopsAndDoesNotGoOnWhenALinkComesBack) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::cut, .device = "servo", .from = 14.0, .until = 16.0});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);  // the stop was sent and confirmed when the link was up
  EXPECT_EQ(bench.state.phase, RunPhase::safe);
  EXPECT_EQ(bench.true_rate("table"), 0.0);
  EXPECT_TRUE(bench.faults_of_order.empty());
  EXPECT_LT(bench.recorded.size(), 4u);
}

TEST(Executive, SurvivesASilenceThatIsShorterThanDeclared) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::silent, .device = "servo", .from = 20.0, .until = 20.2});
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
}

TEST(Executive, TakesItsOwnSleepForNoSilenceOfTheDevices) {
  for (const double began : {12.0, 12.001, 12.05, 12.099}) {  // between two polls, and while a reply is on its way
    ExecutiveBench bench(bench_course(table_schedule()));
    bench.run(began);
    bench.sleep(began + 100.0);
    EXPECT_EQ(bench.run(10000.0), RunEnding::complete) << began;
    const auto late = std::ranges::find(bench.notes, EventKind::late, &Note::kind);
    ASSERT_NE(late, bench.notes.end());
    EXPECT_TRUE(late->text.text().find(" for 99.9 s") != std::string::npos ||
                late->text.text().find(" for 100 s") != std::string::npos)
        << late->text.text();
  }
}

TEST(Executive, FindsATableThatWasLostWhileItSlept) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::silent, .device = "servo", .from = 3.0});
  bench.run(2.9);
  bench.sleep(103.0);
  EXPECT_EQ(bench.run(10000.0), RunEnding::faulted);
  EXPECT_LE(bench.phase_began.at("stopping"), 103.0 + 0.6);
}

// Point 7 of the design: the state is read before anything is sent again.
TEST(Executive, ReadsBeforeItSendsAgain) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::deaf_reply, .device = "servo", .from = 0.0, .until = 20.0, .verb = ControllerVerb::rate});
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  bool read_between = true;
  for (const auto& one : bench.asked) {
    const auto& verb = one.ask.request.verb;
    if (one.ask.device != "servo") continue;
    EXPECT_TRUE(verb != ControllerVerb::rate || read_between) << one.time;
    read_between = verb != ControllerVerb::rate && (read_between || verb == ControllerVerb::read);
  }
}

TEST(Executive, NeverSendsTwiceWhatIsToBeSentOnce) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::deaf_reply, .device = "servo", .from = 0.0, .verb = ControllerVerb::enable});
  EXPECT_EQ(bench.run(1000.0), RunEnding::error);
  EXPECT_EQ(asked_for(bench, ControllerVerb::enable).size(), 1u);
  EXPECT_EQ(bench.state.phase, RunPhase::safe);
}

TEST(Executive, RefusesAnotherDeviceAtTheLink) {
  Station station = bench_station();
  station.devices[0].identity = "SN 8";
  ExecutiveBench bench(bench_course(table_schedule(), station));
  EXPECT_EQ(bench.run(1000.0), RunEnding::error);
  EXPECT_NE(bench.ended->text.text().find("does not contain 'SN 8'"), std::string::npos) << bench.ended->text.text();
  EXPECT_EQ(asked_for(bench, ControllerVerb::position).size(), 0u);
}

}  // namespace
}  // namespace tumble
