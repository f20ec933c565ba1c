// Interlocks, tolerances, prompts, pause and stop.
#include <gtest/gtest.h>

#include <cmath>

#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/unit.hpp"

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
using testing::table_schedule;
using testing::warm_to;
using Fault = BenchFault::Kind;

// Point 30: slow chamber, hold condition, alarm.
TEST(Executive, AsksAPersonWhenAChamberIsTooSlow) {
  Station station = bench_station();
  station.axes[1].retries = 0;
  ExecutiveBench bench(bench_course({bench_segment("warm", 100.0, {{"chamber", warm_to(40.0)}})}, station));
  bench.fault({.kind = Fault::slow, .device = "climate", .from = 0.0, .size = 0.01});  // 2000 s for 20 K
  bench.answering = [](const Prompt&) { return std::pair(60.0, std::string("repeat")); };
  EXPECT_EQ(bench.run(1e4), RunEnding::complete);
  ASSERT_EQ(bench.prompts.size(), 2u);  // 900 s each, and then 150 s more
  EXPECT_NE(bench.prompts[0].text.text().find("chamber has not settled within 900 s"), std::string::npos);
  EXPECT_EQ(bench.prompts[0].at_deadline, "hold");
  const auto ends = rows_of_kind(bench, RunRow::Kind::segment_ends);
  ASSERT_EQ(ends.size(), 3u);
  EXPECT_EQ(ends[0].ending, RunRow::Ending::failed);
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
  EXPECT_NE(bench.ended->text.text().find("reads 0.02 deg/s from the demand, the tolerance is 0.01 deg/s"),
            std::string::npos)
      << bench.ended->text.text();
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
  const auto refused = std::find_if(bench.notes.begin(), bench.notes.end(),
                                    [](const Note& note) { return note.kind == EventKind::refused; });
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
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::segment_ends)[1].ending, RunRow::Ending::paused);
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
  EXPECT_EQ(asked_for(bench, ControllerVerb::stop).size(), 1u);
  EXPECT_EQ(asked_for(bench, ControllerVerb::hold).size(), 1u);
  EXPECT_EQ(bench.true_rate("table"), 0.0);
  EXPECT_EQ(rows_of_kind(bench, RunRow::Kind::run_ends).back().ending, RunRow::Ending::stopped);
}

TEST(Executive, SaysToAPersonThatTheRigIsNotSafe) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::stuck, .device = "servo", .from = 19.0});
  bench.at(20.0, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::faulted);
  EXPECT_EQ(bench.state.phase, RunPhase::faulted);
  EXPECT_NEAR(bench.ended_at, 20.0 + bench.state.course->station.safe[0].within, 5.0 * bench.reply_after);
  EXPECT_EQ(bench.ended->text.text().rfind("THE RIG IS NOT SAFE. servo: 'stop' was not confirmed within 5 s", 0), 0u)
      << bench.ended->text.text();
}

TEST(Executive, SendsAStopAgainOnlyAfterItHasReadTheRate) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.fault({.kind = Fault::refuses, .device = "servo", .from = 19.0, .until = 21.0, .verb = ControllerVerb::stop});
  bench.at(20.0, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  bool read_between = true;
  for (const auto& one : bench.asked) {
    if (one.ask.device != "servo") continue;
    EXPECT_TRUE(one.ask.request.verb != ControllerVerb::stop || read_between);
    read_between = one.ask.request.verb != ControllerVerb::stop;
  }
  EXPECT_GT(asked_for(bench, ControllerVerb::stop).size(), 2u);
}

TEST(Executive, SwitchesTheUnitOffOnlyWhenTheTableStands) {
  ExecutiveBench bench(bench_course(table_schedule(), bench_station(true)));
  bench.at(20.0, RunOrder{RunOrder::Kind::stop, "SIGTERM"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  const auto off = std::find_if(bench.asked.begin(), bench.asked.end(),
                                [](const auto& one) { return one.ask.request.verb == ControllerVerb::off; });
  ASSERT_NE(off, bench.asked.end());
  EXPECT_GT(off->time, 20.0 + si(20.0, "deg/s") / 2.0);  // the bench slows down with 2 rad/s^2
}

TEST(Executive, StopsWhenNothingCanBeRecordedAnyMore) {
  ExecutiveBench bench(bench_course(table_schedule()));
  bench.at(20.0, StoreFailed{"no space on the disk"});
  EXPECT_EQ(bench.run(1000.0), RunEnding::stopped);
  EXPECT_EQ(bench.ended->text, "the recording has stopped: no space on the disk");
}

}  // namespace
}  // namespace tumble
