#include "tumble/station/executive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tumble/math/random.hpp"
#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

using testing::bench_segment;
using testing::bench_station;
using testing::BenchFault;
using testing::ExecutiveBench;
using Fault = BenchFault::Kind;

Motion hold_at(double degrees) { return {.kind = Motion::Kind::hold, .value = si(degrees, "deg")}; }
Motion turn_at(double degrees_per_second) {
  return {.kind = Motion::Kind::rate, .value = si(degrees_per_second, "deg/s")};
}
Motion warm_to(double celsius) { return {.kind = Motion::Kind::dwell, .value = si(celsius, "degC")}; }

/// Rest, two rates, rest; 10 s each.
Schedule table_schedule() {
  return {bench_segment("rest", 10.0, {{"table", hold_at(0.0)}}),
          bench_segment("forwards", 10.0, {{"table", turn_at(20.0)}}),
          bench_segment("backwards", 10.0, {{"table", turn_at(-20.0)}}),
          bench_segment("90 deg", 10.0, {{"table", hold_at(90.0)}})};
}

std::shared_ptr<const Course> bench_course(Schedule schedule, Station station = bench_station()) {
  return std::make_shared<const Course>(Course{.station = std::move(station), .schedule = std::move(schedule)});
}

std::vector<RunRow> rows_of_kind(const ExecutiveBench& bench, RunRow::Kind kind) {
  std::vector<RunRow> rows;
  for (const auto& row : bench.rows)
    if (row.kind == kind) rows.push_back(row);
  return rows;
}

std::size_t asks_of(const ExecutiveBench& bench, const std::string& verb) {
  return static_cast<std::size_t>(std::count_if(bench.asked.begin(), bench.asked.end(),
                                                [&](const auto& one) { return one.ask.request.verb == verb; }));
}

TEST(Executive, CarriesOutASchedule) {
  ExecutiveBench bench(bench_course(table_schedule()));
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_TRUE(bench.faults_of_order.empty());
  ASSERT_EQ(bench.recorded.size(), 4u);
  for (const auto& one : bench.recorded) EXPECT_NEAR(one.end - one.begin, 10.0, 1e-9) << one.what.label;
  const auto ends = rows_of_kind(bench, RunRow::Kind::segment_ends);
  ASSERT_EQ(ends.size(), 4u);
  EXPECT_EQ(ends[1].ending, "complete");
  EXPECT_NEAR(ends[1].achieved.at("table.rate"), si(20.0, "deg/s"), 1e-12);
  const double turns = (bench.true_position("table") - si(90.0, "deg")) / two_pi;
  EXPECT_NEAR(turns, std::round(turns), 1e-9);
  EXPECT_EQ(counted_attempts(bench.rows).size(), 4u);
}

TEST(Executive, TheTableOfTransitionsHasNoDeadEndAndNoWayOutOfAnEnd) {
  for (const auto from : all_phases()) {
    bool leads_on = false;
    for (const auto to : all_phases()) {
      leads_on = leads_on || may_follow(from, to);
      EXPECT_FALSE(is_end(from) && may_follow(from, to)) << name(from) << name(to);
    }
    EXPECT_EQ(leads_on, !is_end(from)) << name(from);
    EXPECT_FALSE(may_follow(from, RunPhase::idle));
    if (from != RunPhase::stopping && from != RunPhase::aborting) {
      EXPECT_FALSE(may_follow(from, RunPhase::safe));
      EXPECT_FALSE(may_follow(from, RunPhase::faulted));
      EXPECT_EQ(may_follow(from, RunPhase::stopping), !is_end(from));
    }
  }
  EXPECT_FALSE(may_follow(RunPhase::stopping, RunPhase::moving));
  EXPECT_FALSE(may_follow(RunPhase::stopping, RunPhase::aborting));
  EXPECT_FALSE(may_follow(RunPhase::paused, RunPhase::recording));
}

TEST(Executive, CommitsTheRowOfAnAttemptBeforeItsMotion) {
  const auto course = bench_course(table_schedule());
  ExecutiveBench bench(course);
  bench.run(1000.0);
  std::size_t begun = 0;
  for (const auto& one : bench.asked) {
    const auto& verb = one.ask.request.verb;
    if (verb != "position" && verb != "rate") continue;
    ++begun;
    EXPECT_LE(rows_of_kind(bench, RunRow::Kind::segment_begins).at(begun - 1).time, one.time);
  }
  EXPECT_EQ(begun, 4u);
}

TEST(Executive, SoaksAChamberAfterItHasSettled) {
  // 20 K at 0.5 K/s: 40 s; within 0.5 K a second before; 30 s hold, 60 s soak.
  ExecutiveBench bench(bench_course({bench_segment("warm", 100.0, {{"chamber", warm_to(40.0)}})}));
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  ASSERT_EQ(bench.recorded.size(), 1u);
  EXPECT_GT(bench.recorded[0].begin, 39.0 + 30.0 + 60.0);
  EXPECT_LT(bench.recorded[0].begin, 39.0 + 60.0 + 60.0 + 5.0);  // the first windows have the slope of the ramp
}

TEST(Executive, StepsARamp) {
  const Motion ramp{.kind = Motion::Kind::ramp, .value = si(6.0, "K/min"), .to = si(40.0, "degC")};
  ExecutiveBench bench(bench_course(
      {bench_segment("cold", 10.0, {{"chamber", warm_to(20.0)}}), bench_segment("ramp", 200.0, {{"chamber", ramp}})}));
  ASSERT_EQ(bench.run(2000.0), RunEnding::complete);
  // 20 K in steps of 1 K, beside the set points of the two segments before recording
  EXPECT_EQ(asks_of(bench, "set_temperature"), 22u);
  EXPECT_NEAR(bench.recorded[1].end - bench.recorded[1].begin, 200.0, 1e-9);
  EXPECT_NEAR(std::get<double>(bench.state.channels.at("chamber.temperature").value), si(40.0, "degC"), 1e-9);
}

// Point 28: a cable is pulled, in three ways.
TEST(Executive, BecomesSafeOnTheOtherLinksAtOnceWhenALinkIsLost) {
  for (const auto kind : {Fault::cut, Fault::silent}) {
    ExecutiveBench bench(bench_course(table_schedule()));
    bench.fault({.kind = kind, .device = "climate", .from = 10.03});
    EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);  // nobody knows of the chamber
    const double decided = bench.phase_began.at("stopping");
    EXPECT_LE(decided, 10.03 + (kind == Fault::cut ? 1e-9 : 10.0 + 1e-9));
    const auto stop = std::find_if(bench.asked.begin(), bench.asked.end(),
                                   [](const auto& one) { return one.ask.request.verb == "stop" && one.ask.urgent; });
    ASSERT_NE(stop, bench.asked.end());
    EXPECT_LE(stop->time - decided, 0.1);
    EXPECT_TRUE(bench.faults_of_order.empty());
    EXPECT_EQ(bench.true_rate("table"), 0.0);
    EXPECT_NE(bench.ended->text.find("climate: 'hold' was not confirmed"), std::string::npos) << bench.ended->text;
  }
}

TEST(Executive, DecidesThatATableIsLostAfterTheDeclaredSilence) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::silent, .device = "servo", .from = 10.0});
  EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);
  EXPECT_LE(bench.phase_began.at("stopping"), 10.0 + bench.reply_after + 0.5 + 1e-9);
  EXPECT_GE(bench.phase_began.at("stopping"), 10.0 + 0.5 - 0.1 - 0.01);
  EXPECT_NE(bench.ended->text.find("emergency stop of servo"), std::string::npos) << bench.ended->text;
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
    const auto late = std::ranges::find(bench.notes, "late", &Note::kind);
    ASSERT_NE(late, bench.notes.end());
    EXPECT_TRUE(late->text.find(" for 99.9 s") != std::string::npos ||
                late->text.find(" for 100 s") != std::string::npos)
        << late->text;
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
  bench.fault({.kind = Fault::deaf_reply, .device = "servo", .from = 0.0, .until = 20.0, .verb = "rate"});
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  bool read_between = true;
  for (const auto& one : bench.asked) {
    const auto& verb = one.ask.request.verb;
    if (one.ask.device != "servo") continue;
    EXPECT_TRUE(verb != "rate" || read_between) << one.time;
    read_between = verb != "rate" && (read_between || verb == "read");
  }
}

TEST(Executive, NeverSendsTwiceWhatIsToBeSentOnce) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::deaf_reply, .device = "servo", .from = 0.0, .verb = "enable"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::error);
  EXPECT_EQ(asks_of(bench, "enable"), 1u);
  EXPECT_EQ(bench.state.phase, RunPhase::safe);
}

TEST(Executive, RefusesAnotherDeviceAtTheLink) {
  Station station = bench_station();
  station.devices[0].identity = "SN 8";
  ExecutiveBench bench(bench_course(table_schedule(), station));
  EXPECT_EQ(bench.run(1000.0), RunEnding::error);
  EXPECT_NE(bench.ended->text.find("does not contain 'SN 8'"), std::string::npos) << bench.ended->text;
  EXPECT_EQ(asks_of(bench, "position"), 0u);
}

// Point 30: slow chamber, hold condition, alarm.
TEST(Executive, AsksAPersonWhenAChamberIsTooSlow) {
  Station station = bench_station();
  station.axes[1].retries = 0;
  ExecutiveBench bench(bench_course({bench_segment("warm", 100.0, {{"chamber", warm_to(40.0)}})}, station));
  bench.fault({.kind = Fault::slow, .device = "climate", .from = 0.0, .size = 0.01});  // 2000 s for 20 K
  bench.answering = [](const Prompt&) { return std::pair(60.0, std::string("repeat")); };
  EXPECT_EQ(bench.run(1e4), RunEnding::complete);
  ASSERT_EQ(bench.prompts.size(), 2u);  // 900 s each, and then 150 s more
  EXPECT_NE(bench.prompts[0].text.find("chamber has not settled within 900 s"), std::string::npos);
  EXPECT_EQ(bench.prompts[0].at_deadline, "hold");
  const auto ends = rows_of_kind(bench, RunRow::Kind::segment_ends);
  ASSERT_EQ(ends.size(), 3u);
  EXPECT_EQ(ends[0].ending, "failed");
  EXPECT_EQ(ends[2].attempt, 3);
}

Station station_with(const std::string& requirement, StationInterlock::Action action, double debounce) {
  Station station = bench_station();
  station.interlocks.push_back(
      {.require = parse_requirement(requirement), .action = action, .debounce = debounce, .stale = 1e9});
  return station;
}

TEST(Executive, BeginsTheDwellAgainAfterAHold) {
  const auto station = station_with("lab.humidity < 60", StationInterlock::Action::hold, 2.0);
  ExecutiveBench bench(bench_course({bench_segment("warm", 100.0, {{"chamber", warm_to(40.0)}})}, station));
  const auto humid = [](double value) { return ChannelValues{{{"lab.humidity", value}}}; };
  bench.at(0.0, humid(50.0));
  bench.at(110.0, humid(65.0));  // in the dwell of 60 s, which began after 69 s and before 105 s
  bench.at(200.0, humid(50.0));
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  ASSERT_EQ(bench.recorded.size(), 1u);
  EXPECT_GE(bench.recorded[0].begin, 200.0 + 2.0 + 30.0 + 60.0);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::segment_ends).size(), 1u);  // one attempt
}

TEST(Executive, RepeatsASegmentThatWasHeldWhileItWasRecorded) {
  const auto station = station_with("lab.humidity < 60", StationInterlock::Action::hold, 1.0);
  ExecutiveBench bench(bench_course(table_schedule(), station));
  bench.at(0.0, ChannelValues{{{"lab.humidity", 50.0}}});
  bench.at(5.0, ChannelValues{{{"lab.humidity", 70.0}}});
  bench.at(5.5, ChannelValues{{{"lab.humidity", 50.0}}});  // shorter than the debounce time
  bench.at(7.0, ChannelValues{{{"lab.humidity", 70.0}}});
  bench.at(50.0, ChannelValues{{{"lab.humidity", 50.0}}});
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  ASSERT_EQ(bench.recorded.size(), 5u);
  EXPECT_NEAR(bench.recorded[0].end, 8.0, 1e-9);
  EXPECT_EQ(bench.recorded[1].what.attempt, 2);
  EXPECT_EQ(counted_attempts(bench.rows).at(0), 2);
}

TEST(Executive, StopsInTheStepInWhichAnInterlockBreaks) {
  const auto station = station_with("input.door == closed", StationInterlock::Action::stop, 0.0);
  ExecutiveBench bench(bench_course(table_schedule(), station));
  bench.at(0.0, ChannelValues{{}, {{"input.door", "closed"}}});
  bench.at(20.0, ChannelValues{{}, {{"input.door", "open"}}});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_EQ(bench.state.decided, 20.0);
  const auto stop =
      std::find_if(bench.asked.begin(), bench.asked.end(), [](const auto& one) { return one.ask.urgent; });
  EXPECT_EQ(stop->time, 20.0);
  EXPECT_LT(bench.ended_at, 21.0);
}

TEST(Executive, StopsWhenAChannelOfAnInterlockHasNoNews) {
  auto station = station_with("input.door == closed", StationInterlock::Action::stop, 0.0);
  station.interlocks[0].stale = 5.0;
  ExecutiveBench bench(bench_course(table_schedule(), station));
  bench.at(1.0, ChannelValues{{}, {{"input.door", "closed"}}});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_NEAR(bench.state.decided, 6.0, 1e-9);
}

TEST(Executive, StopsWhenTheChamberReportsAnAlarm) {
  ExecutiveBench bench(bench_course({bench_segment("warm", 100.0, {{"chamber", warm_to(40.0)}})}));
  bench.fault({.kind = Fault::alarm, .device = "climate", .from = 30.0});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_LE(bench.state.decided, 30.0 + 5.0 + 1.0);  // its state is asked with every fifth poll
}

// Point 31: a table that drifts.
TEST(Executive, DoesNotAcceptARateOutOfTolerance) {
  Station station = bench_station();
  station.axes[0].on_failure = OnFailure::stop;
  ExecutiveBench bench(bench_course(table_schedule(), station));
  bench.fault({.kind = Fault::off_rate, .device = "servo", .size = 1e-3});  // 0.02 deg/s, twice the tolerance
  EXPECT_EQ(bench.run(1000.0), RunEnding::failed);
  EXPECT_NE(bench.ended->text.find("reads 0.02 deg/s from the demand, the tolerance is 0.01 deg/s"), std::string::npos)
      << bench.ended->text;
}

TEST(Executive, StatesTheRateThatWasMeasured) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::off_rate, .device = "servo", .size = 2e-4});
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_NEAR(rows_of_kind(bench, RunRow::Kind::segment_ends)[1].achieved.at("table.rate"), si(20.004, "deg/s"), 1e-12);
  EXPECT_NEAR(rows_of_kind(bench, RunRow::Kind::segment_ends)[1].demanded.at("table.rate"), si(20.0, "deg/s"), 1e-12);
}

TEST(Executive, RepeatsASegmentWhoseAxisLeavesItsTolerance) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::noise, .device = "servo", .from = 20.0, .until = 21.0, .size = si(0.05, "deg")});
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(bench.recorded.size(), 5u);
  EXPECT_EQ(counted_attempts(bench.rows).at(1), 2);
}

TEST(Executive, AsksWhenAnAxisNeverSettlesAndSkipsIfToldSo) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::noise, .device = "servo", .from = 14.0, .until = 100.0, .size = si(0.05, "deg")});
  bench.answering = [](const Prompt&) { return std::pair(20.0, std::string("skip")); };
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(bench.prompts.size(), 1u);  // two attempts of 30 s, a question, and the rest of the segments
  EXPECT_EQ(counted_attempts(bench.rows).size(), 3u);
  EXPECT_EQ(bench.state.segments[1].status, SegmentProgress::Status::skipped);
}

// Point 32: a late operator.
TEST(Executive, HoldsTheRigAtRestUntilSomebodyAnswers) {
  Station station = bench_station();
  station.devices[0].poll = 1.0;
  station.devices[0].lost_after = 5.0;
  ExecutiveBench bench(bench_course(table_schedule(), station));
  const double night = 12.0 * hour;
  bench.fault({.kind = Fault::off_rate, .device = "servo", .from = 0.0, .until = night, .size = 1e-3});
  bench.answering = [&](const Prompt&) { return std::pair(night, std::string("repeat")); };
  bench.run(night / 2.0);
  EXPECT_EQ(bench.state.phase, RunPhase::holding);
  EXPECT_EQ(bench.true_rate("table"), 0.0);
  EXPECT_EQ(bench.run(2.0 * night), RunEnding::complete);
  EXPECT_EQ(bench.prompts.size(), 1u);
  EXPECT_EQ(counted_attempts(bench.rows).at(1), 3);
}

TEST(Executive, RefusesAnswersThatAreLateOrNotOffered) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::off_rate, .device = "servo", .size = 1e-3});
  bench.at(200.0, PromptAnswer{1, "carry on", "Li"});
  bench.at(210.0, RunOrder{RunOrder::Kind::abort, "Li"});
  bench.at(260.0, PromptAnswer{1, "repeat", "Wang"});
  EXPECT_EQ(bench.run(250.0), RunEnding::aborted);
  std::vector<RunAction> actions;
  const auto after = step(bench.state, {260.0, PromptAnswer{1, "repeat", "Wang"}}, actions);
  EXPECT_EQ(after.phase, RunPhase::safe);
  ASSERT_EQ(actions.size(), 1u);
  EXPECT_EQ(std::get<Note>(actions[0]).text, "Wang: question 1 is closed");
  const auto refused =
      std::find_if(bench.notes.begin(), bench.notes.end(), [](const Note& note) { return note.kind == "refused"; });
  ASSERT_NE(refused, bench.notes.end());
  EXPECT_EQ(refused->text, "Li: 'carry on' is no answer to question 1; accepted: repeat, skip, stop");
}

TEST(Executive, AsksForWhatIsTurnedByHandAndOnlyWhereItChanges) {
  Station station = bench_station();
  station.by_hand = {"mount_yaw"};
  Schedule schedule = table_schedule();
  schedule[0].axes["mount_yaw"] = hold_at(0.0);
  schedule[2].axes["mount_yaw"] = hold_at(180.0);
  ExecutiveBench bench(bench_course(schedule, station));
  bench.answering = [](const Prompt&) { return std::pair(100.0, std::string("done")); };
  EXPECT_EQ(bench.run(2000.0), RunEnding::complete);
  ASSERT_EQ(bench.prompts.size(), 2u);
  EXPECT_EQ(bench.prompts[1].text, "Segment 'backwards': turn the instrument by hand: mount_yaw to 180 deg");
}

// Pauses.
TEST(Executive, PausesAtOnceAndRepeatsTheSegment) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.at(20.0, RunOrder{RunOrder::Kind::pause, "Li"});
  bench.at(500.0, RunOrder{RunOrder::Kind::resume, "Li"});
  bench.run(499.0);
  EXPECT_EQ(bench.state.phase, RunPhase::paused);
  EXPECT_EQ(bench.true_rate("table"), 0.0);
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(counted_attempts(bench.rows).at(1), 2);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::segment_ends)[1].ending, "paused");
}

TEST(Executive, PausesAtACheckpointWithoutLossOfASegment) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.at(20.0, RunOrder{RunOrder::Kind::pause_at_checkpoint, "Li"});
  bench.at(500.0, RunOrder{RunOrder::Kind::resume, "Li"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  for (const auto& [segment, attempt] : counted_attempts(bench.rows)) EXPECT_EQ(attempt, 1) << segment;
  EXPECT_LT(bench.phase_began.at("paused"), 40.0);
}

// Point 35: signals, and a safe list that cannot be confirmed.
TEST(Executive, RunsTheSafeListOnceHoweverOftenItIsToldToStop) {
  ExecutiveBench bench(bench_course(table_schedule()));
  for (const double time : {20.0, 20.01, 20.2}) bench.at(time, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  bench.at(20.1, RunOrder{RunOrder::Kind::abort, "Li"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_EQ(asks_of(bench, "stop"), 1u);
  EXPECT_EQ(asks_of(bench, "hold"), 1u);
  EXPECT_EQ(bench.true_rate("table"), 0.0);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::run_ends).back().ending, "stopped");
}

TEST(Executive, SaysToAPersonThatTheRigIsNotSafe) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::stuck, .device = "servo", .from = 19.0});
  bench.at(20.0, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);
  EXPECT_EQ(bench.state.phase, RunPhase::faulted);
  EXPECT_NEAR(bench.ended_at, 25.0, 0.01);
  EXPECT_EQ(bench.ended->text.rfind("THE RIG IS NOT SAFE. servo: 'stop' was not confirmed within 5 s", 0), 0u)
      << bench.ended->text;
}

TEST(Executive, SendsAStopAgainOnlyAfterItHasReadTheRate) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::refuses, .device = "servo", .from = 19.0, .until = 21.0, .verb = "stop"});
  bench.at(20.0, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  bool read_between = true;
  for (const auto& one : bench.asked) {
    if (one.ask.device != "servo") continue;
    EXPECT_TRUE(one.ask.request.verb != "stop" || read_between);
    read_between = one.ask.request.verb != "stop";
  }
  EXPECT_GT(asks_of(bench, "stop"), 2u);
}

TEST(Executive, SwitchesTheUnitOffOnlyWhenTheTableStands) {
  ExecutiveBench bench(bench_course(table_schedule(), bench_station(true)));
  bench.at(20.0, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  const auto off = std::find_if(bench.asked.begin(), bench.asked.end(),
                                [](const auto& one) { return one.ask.request.verb == "off"; });
  ASSERT_NE(off, bench.asked.end());
  EXPECT_GT(off->time, 20.0 + si(20.0, "deg/s") / 2.0);  // the bench slows down with 2 rad/s^2
}

TEST(Executive, StopsWhenNothingCanBeRecordedAnyMore) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.at(20.0, StoreFailed{"no space on the disk"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_EQ(bench.ended->text, "the recording has stopped: no space on the disk");
}

// Point 36: several units.
std::shared_ptr<const Course> three_units(bool all) {
  Course course{.station = bench_station(), .schedule = table_schedule()};
  course.units = {{"1", "A"}, {"2", "B"}, {"3", "C"}};
  course.all_units = all;
  return std::make_shared<const Course>(course);
}

TEST(Executive, GoesOnWithTheUnitsThatRemain) {
  ExecutiveBench bench(three_units(false));
  bench.at(20.0, UnitFailed{"2", "no frames for 2 s"});
  bench.at(21.0, UnitFailed{"2", "no frames for 3 s"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  const auto out = rows_of_kind(bench, RunRow::Kind::unit_out);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].label, "2");
  EXPECT_EQ(counted_attempts(bench.rows).size(), 4u);
}

TEST(Executive, StopsWhenAllUnitsAreNeededOrNoneRemains) {
  ExecutiveBench needed(three_units(true));
  needed.at(20.0, UnitFailed{"2", "no frames"});
  EXPECT_EQ(needed.run(1000.0), RunEnding::failed);
  ExecutiveBench none(three_units(false));
  for (const char* slot : {"1", "2", "3"}) none.at(20.0, UnitFailed{slot, "no frames"});
  EXPECT_EQ(none.run(1000.0), RunEnding::failed);
}

// Stopping rules.
TEST(Executive, EndsASegmentWhenTheEstimateIsGoodEnough) {
  Course course{.station = bench_station(), .schedule = {bench_segment("long", 1000.0, {{"table", hold_at(0.0)}})}};
  course.units = {{"1", "A"}};
  course.until["long"] = parse_stopping_rule("sd(bias) <= 0.002 deg/h", 100.0);
  ExecutiveBench bench(std::make_shared<const Course>(course));
  const double good = si(0.0019, "deg/h"), poor = si(0.0021, "deg/h");
  bench.at(20.0, EstimateNow{"1", "bias", 0.0, good});  // too early to end
  bench.at(90.0, EstimateNow{"1", "bias", 0.0, poor});
  bench.at(200.0, EstimateNow{"1", "drift", 0.0, good});
  bench.at(300.0, EstimateNow{"1", "bias", 0.0, good});
  EXPECT_EQ(bench.run(2000.0), RunEnding::complete);
  const auto ends = rows_of_kind(bench, RunRow::Kind::segment_ends);
  ASSERT_EQ(ends.size(), 1u);
  EXPECT_EQ(ends[0].rule, "sd(bias) <= 0.002 deg/h");
  EXPECT_NEAR(bench.recorded[0].end, 300.0, 1e-9);
  EXPECT_NEAR(ends[0].reached.value(), 300.0 - bench.recorded[0].begin, 1e-9);
  for (const char* bad : {"", "sd() <= 1 deg/h", "sd(bias) >= 1 deg/h", "bias <= 1 deg/h", "sd(bias) <= -1 deg/h"})
    EXPECT_THROW(parse_stopping_rule(bad, 1.0), Error) << bad;
}

// Power-ups.
TEST(Executive, SwitchesTheSupplyBetweenPowerUps) {
  Schedule schedule{bench_segment("first", 10.0, {{"table", hold_at(0.0)}}, 1),
                    bench_segment("second", 10.0, {{"table", hold_at(0.0)}}, 2)};
  ExecutiveBench bench(bench_course(schedule, bench_station(true)));
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(asks_of(bench, "off"), 2u);
  EXPECT_GE(bench.recorded[1].begin - bench.recorded[0].end, 60.0);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::power_up).size(), 2u);
}

TEST(Executive, AsksAPersonForAPowerUpWhereThereIsNoSupply) {
  Schedule schedule{bench_segment("first", 10.0, {{"table", hold_at(0.0)}}, 1),
                    bench_segment("second", 10.0, {{"table", hold_at(0.0)}}, 2)};
  ExecutiveBench bench(bench_course(schedule));
  bench.answering = [](const Prompt&) { return std::pair(3000.0, std::string("done")); };
  EXPECT_EQ(bench.run(1e4), RunEnding::complete);
  ASSERT_EQ(bench.prompts.size(), 1u);
  EXPECT_EQ(bench.prompts[0].text, "Switch the instrument off, wait 60 s, and switch it on: power-up 2");
}

// Point 27: the journal is cut at every row, as by a kill.
void resume_at_every_row(const Schedule& schedule, bool supply) {
  const auto course = bench_course(schedule, bench_station(supply));
  ExecutiveBench whole(course);
  ASSERT_EQ(whole.run(1e5), RunEnding::complete);
  for (std::size_t cut = 0; cut + 1 < whole.rows.size(); ++cut) {
    std::vector<RunRow> journal(whole.rows.begin(), whole.rows.begin() + static_cast<std::ptrdiff_t>(cut));
    const auto before = counted_attempts(journal);
    ExecutiveBench rest(course, resume_state(course, journal));
    ASSERT_EQ(rest.run(1e5), RunEnding::complete) << cut;
    EXPECT_TRUE(rest.faults_of_order.empty());
    std::set<std::pair<std::size_t, int>> attempts;
    for (const auto& row : journal)
      if (row.kind == RunRow::Kind::segment_begins) attempts.emplace(row.segment, row.attempt);
    for (const auto& row : rest.rows) {
      if (row.kind != RunRow::Kind::segment_begins) continue;
      EXPECT_TRUE(attempts.emplace(row.segment, row.attempt).second) << "attempt twice, cut " << cut;
    }
    journal.insert(journal.end(), rest.rows.begin(), rest.rows.end());
    EXPECT_EQ(counted_attempts(journal).size(), schedule.size()) << cut;
    for (const auto& [segment, attempt] : before)
      EXPECT_TRUE(supply || counted_attempts(journal).at(segment) == attempt);
  }
}

TEST(Executive, IsResumedFromEveryRowOfItsJournal) { resume_at_every_row(table_schedule(), false); }

TEST(Executive, RepeatsAWholePowerUpThatWasInterrupted) {
  Schedule schedule;
  for (int run = 1; run <= 2; ++run)
    for (const char* label : {"rest", "turned"})
      schedule.push_back(bench_segment(label, 10.0, {{"table", label[0] == 'r' ? hold_at(0.0) : hold_at(30.0)}}, run));
  resume_at_every_row(schedule, true);
}

TEST(Executive, PutsAxesWhereEarlierSegmentsHeldThemWhenItIsResumed) {
  Schedule schedule = table_schedule();
  schedule[0].axes["table"] = hold_at(45.0);
  schedule[1].axes = {{"chamber", warm_to(25.0)}};
  const auto course = bench_course(schedule);
  ExecutiveBench whole(course);
  ASSERT_EQ(whole.run(1e4), RunEnding::complete);
  std::vector<RunRow> journal;
  for (const auto& row : whole.rows) {
    if (row.kind == RunRow::Kind::segment_begins && row.segment == 1) break;
    journal.push_back(row);
  }
  ExecutiveBench rest(course, resume_state(course, journal));
  while (rest.recorded.empty() && rest.run(rest.state.now + 1.0) != RunEnding::complete) {
  }
  EXPECT_NEAR(rest.true_position("table"), si(45.0, "deg"), 1e-12);
}

/// Faults, orders and answers at random times, all from one seed.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double upto(double most) { return most * random_.uniform(count_++); }
  std::size_t pick(std::size_t count) { return static_cast<std::size_t>(upto(static_cast<double>(count))); }

 private:
  RandomStream random_;
  std::uint64_t count_ = 0;
};

void shake(ExecutiveBench& bench, std::uint64_t seed) {
  Dice dice(seed);
  const std::vector<std::string> devices{"servo", "climate", "supply"};
  const std::vector<std::string> verbs{"stop", "read", "rate", "position", "set_temperature", "enable", "off", "hold"};
  const std::vector<std::string> choices{"repeat", "skip", "stop", "done", "nonsense"};
  for (std::size_t i = dice.pick(4); i > 0; --i) {
    BenchFault fault{.kind = static_cast<Fault>(dice.pick(10)), .device = devices[dice.pick(3)]};
    fault.from = dice.pick(4) == 0 ? 0.0 : dice.upto(250.0);
    fault.until = fault.from + dice.upto(100.0) * dice.upto(1.0);
    fault.verb = verbs[dice.pick(verbs.size())];
    fault.size = std::pow(10.0, -dice.upto(6.0));
    bench.fault(fault);
  }
  for (std::size_t i = dice.pick(4); i > 0; --i) {
    const double time = dice.upto(300.0);
    bench.at(time, RunOrder{static_cast<RunOrder::Kind>(dice.pick(6)), "Li"});
  }
  for (std::size_t i = dice.pick(3); i > 0; --i) {
    const double time = dice.upto(300.0);
    bench.at(time, ChannelValues{{}, {{"input.door", dice.pick(2) == 0 ? "open" : "closed"}}});
  }
  const double time = dice.upto(300.0);
  if (dice.pick(8) == 0) bench.at(time, StoreFailed{"no space"});
  if (dice.pick(5) == 0) bench.at(time, UnitFailed{"1", "silent"});
  if (dice.pick(3) == 0) bench.at(time, PromptAnswer{1, choices[dice.pick(choices.size())], "Wang"});
  if (dice.pick(4) != 0) {
    const double after = dice.upto(50.0);
    const std::string choice = choices[dice.pick(choices.size())];
    bench.answering = [=](const Prompt& prompt) {
      return std::pair(after, choice == "nonsense" ? prompt.standard : choice);
    };
  }
  bench.at(600.0, RunOrder{RunOrder::Kind::abort, "evening"});
}

TEST(Executive, EndsSafelyWhateverHappens) {
  Station station = bench_station(true);
  station.axes[0].settle.timeout = 10.0;
  station.axes[1].settle = {.value = 0.5, .hold = 5.0, .timeout = 100.0, .soak = 5.0};
  for (auto& device : station.devices) {
    device.poll = 1.0;
    device.timeout = 0.7;
    device.lost_after = 5.0;
  }
  station.interlocks.push_back({.require = parse_requirement("input.door == closed"),
                                .action = StationInterlock::Action::hold,
                                .debounce = 0.5,
                                .stale = 1e9});
  station.by_hand = {"mount_yaw"};
  station.power.off_time = 5.0;
  Schedule schedule = table_schedule();
  schedule[1].axes["chamber"] = warm_to(22.0);
  schedule[2].axes["mount_yaw"] = hold_at(90.0);
  schedule.push_back(bench_segment("again", 5.0, {{"table", hold_at(0.0)}}, 2));
  Course course{.station = station, .schedule = schedule};
  course.units = {{"1", "A"}, {"2", "B"}};
  course.prompt_deadline = 30.0;
  const auto shared = std::make_shared<const Course>(course);
  std::map<RunEnding, int> endings;
  for (std::uint64_t seed = 1; seed <= 10'000; ++seed) {
    ExecutiveBench bench(shared);
    bench.at(0.0, ChannelValues{{}, {{"input.door", "closed"}}});
    shake(bench, seed);
    const auto ending = bench.run(700.0);
    ASSERT_TRUE(ending.has_value()) << "seed " << seed << ": " << name(bench.state.phase);
    ASSERT_TRUE(bench.faults_of_order.empty()) << "seed " << seed << ": " << bench.faults_of_order.front();
    ASSERT_EQ(rows_of_kind(bench, RunRow::Kind::run_ends).size(), 1u) << seed;
    ASSERT_FALSE(bench.state.recording) << seed;
    ASSERT_FALSE(bench.state.attempt_open) << seed;
    ASSERT_TRUE(*ending == RunEnding::faulted || std::abs(bench.true_rate("table")) <= si(0.01, "deg/s")) << seed;
    ++endings[*ending];
  }
  for (const auto ending : {RunEnding::complete, RunEnding::aborted, RunEnding::stopped, RunEnding::failed,
                            RunEnding::error, RunEnding::faulted})
    EXPECT_GT(endings[ending], 5) << name(ending);
}

}  // namespace
}  // namespace tumble
