#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <set>

#include "tumble/math/random.hpp"
#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"
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

TEST(Executive, CarriesOutASchedule) {
  ExecutiveBench bench(bench_course(table_schedule()));
  ASSERT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_TRUE(bench.faults_of_order.empty());
  ASSERT_EQ(bench.recorded.size(), 4u);
  for (const auto& one : bench.recorded) EXPECT_NEAR(one.end - one.begin, 10.0, 1e-9) << one.what.label;
  const auto ends = rows_of_kind(bench, RunRow::Kind::segment_ends);
  ASSERT_EQ(ends.size(), 4u);
  EXPECT_EQ(ends[1].ending, RunRow::Ending::complete);
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
    if (verb != ControllerVerb::position && verb != ControllerVerb::rate) continue;
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
  EXPECT_EQ(asked_for(bench, ControllerVerb::set_temperature).size(), 22u);
  EXPECT_NEAR(bench.recorded[1].end - bench.recorded[1].begin, 200.0, 1e-9);
  EXPECT_NEAR(std::get<double>(bench.state.channels.at("chamber.temperature").value), si(40.0, "degC"), 1e-9);
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
    EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {bad}}, [&] { parse_stopping_rule(bad, 1.0); })) << bad;
}

// Power-ups.
TEST(Executive, SwitchesTheSupplyBetweenPowerUps) {
  Schedule schedule{bench_segment("first", 10.0, {{"table", hold_at(0.0)}}, 1),
                    bench_segment("second", 10.0, {{"table", hold_at(0.0)}}, 2)};
  ExecutiveBench bench(bench_course(schedule, bench_station(true)));
  EXPECT_EQ(bench.run(1000.0), RunEnding::complete);
  EXPECT_EQ(asked_for(bench, ControllerVerb::off).size(), 2u);
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
  const std::vector<ControllerVerb> verbs{ControllerVerb::stop,
                                          ControllerVerb::read,
                                          ControllerVerb::rate,
                                          ControllerVerb::position,
                                          ControllerVerb::set_temperature,
                                          ControllerVerb::enable,
                                          ControllerVerb::off,
                                          ControllerVerb::hold};
  const std::vector<std::string> choices{"repeat", "skip", "stop", "done", "nonsense"};
  for (std::size_t i = dice.pick(4); i > 0; --i) {
    BenchFault fault{.kind = static_cast<BenchFault::Kind>(dice.pick(10)), .device = devices[dice.pick(3)]};
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

/// Runs that are shaken: 10^4 where many inputs are asked for (script/test --full), else enough for each ending.
std::uint64_t shaken_runs() { return std::getenv("TUMBLE_FUZZ_INPUTS") != nullptr ? 10'000 : 5'000; }

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
  const std::uint64_t runs = shaken_runs();
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
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
    EXPECT_GT(endings[ending] * 2000, static_cast<int>(runs)) << name(ending);  // the rarest is one in a thousand
}

}  // namespace
}  // namespace tumble
