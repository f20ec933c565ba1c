// Each kind of fault that a virtual rig can suffer, with the ending that it must have and the state in which it must
// leave the rig: all axes at rest, or a person told that they may not be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::rehearse_faults_test {
namespace {

/// [rad/s] what counts as a rate of zero.
constexpr double at_rest = 0.01 * degree;

Plan plan_of(const std::string& name, std::size_t first, std::size_t count, double duration) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + name + ".toml", {});
  plan.schedule.erase(plan.schedule.begin(), plan.schedule.begin() + static_cast<std::ptrdiff_t>(first));
  plan.schedule.resize(count);
  for (Segment& segment : plan.schedule) {
    segment.duration = duration;
    segment.run = 1;
  }
  return plan;
}

/// A table at -120, -90 and -60 deg/s.
Plan turning() { return plan_of("gyro_scale_factor", 0, 3, 60.0); }

/// A head at 90, 0 and 270 deg, an instrument that sends 5 samples a second.
Plan heading() {
  Plan plan = plan_of("accelerometer_four_position", 1, 3, 60.0);
  plan.sample_rate = 5.0;
  return plan;
}

/// A chamber at -20 degC for 20 minutes.
Plan soaking() { return plan_of("fog_thermal_bias", 0, 1, 1200.0); }

struct FaultCase {
  const char* name;
  Plan (*plan)();
  VirtualFault fault;
  std::set<RunEnding> ends;  ///< one of these
};

std::ostream& operator<<(std::ostream& out, const FaultCase& one) { return out << one.name; }

constexpr double for_ever = 1e9;
constexpr auto complete = RunEnding::complete, stopped = RunEnding::stopped, failed = RunEnding::failed,
               faulted = RunEnding::faulted;

VirtualFault fault(FaultKind kind, const std::string& about, std::optional<double> lasts = {}, double by = 0.0) {
  return {.kind = kind, .name = "it", .about = about, .at = 40.0, .lasts = lasts, .by = by, .ends = "complete"};
}

std::vector<FaultCase> links_of_the_table() {
  using Kind = FaultKind;
  return {
      {"TableDropped", turning, fault(Kind::drop_link, "table", for_ever), {faulted}},
      {"TableDroppedAndBack", turning, fault(Kind::drop_link, "table", 3.0), {stopped}},
      {"TableHalfOpen", turning, fault(Kind::half_open, "table", for_ever), {stopped, faulted}},
      {"TableHalfOpenAndBack", turning, fault(Kind::half_open, "table", 3.0), {stopped}},
      {"TableAnswersLate", turning, fault(Kind::delay, "table", for_ever, 0.2), {complete}},
      {"TableAnswersAfterTheDeadline", turning, fault(Kind::delay, "table", for_ever, 1.0), {stopped, faulted}},
      {"TableGivesAWrongReply", turning, fault(Kind::wrong_reply, "table"), {complete}},
      {"TableGivesWrongRepliesOnly", turning, fault(Kind::wrong_reply, "table", for_ever, 1.0), {stopped, faulted}},
      {"TableSaysHalfALine", turning, fault(Kind::cut_line, "table"), {complete}},
      {"TableSaysHalfLinesOnly", turning, fault(Kind::cut_line, "table", for_ever, 1.0), {stopped, faulted}},
      {"TableSaysANoiseByte", turning, fault(Kind::garbage_byte, "table"), {complete}},
      {"TableSaysNoiseNowAndThen", turning, fault(Kind::garbage_byte, "table", for_ever, 0.02), {complete, stopped}},
      {"TableSaysAWrongBit", turning, fault(Kind::crc_error, "table"), {complete}},
      {"TableSaysWrongBitsNowAndThen", turning, fault(Kind::crc_error, "table", for_ever, 0.02), {complete, stopped}},
      {"TableLosesAReply", turning, fault(Kind::lost_frames, "table"), {complete}},
      {"TableRepeatsAReply", turning, fault(Kind::duplicated_frames, "table"), {complete}},
      {"TableRepeatsAllReplies", turning, fault(Kind::duplicated_frames, "table", for_ever, 1.0), {complete}},
      {"TableRepliesInAnotherOrder", turning, fault(Kind::reordered_frames, "table"), {complete}},
  };
}

std::vector<FaultCase> instruments() {
  using Kind = FaultKind;
  return {
      {"UnitDropped", turning, fault(Kind::drop_link, "unit", for_ever), {failed}},
      {"UnitHalfOpen", turning, fault(Kind::half_open, "unit", for_ever), {failed}},
      {"UnitDelayed", turning, fault(Kind::delay, "unit", for_ever, 0.2), {complete}},
      {"UnitSendsWrongFrames", turning, fault(Kind::wrong_reply, "unit", for_ever, 0.02), {complete}},
      {"UnitSendsHalfFrames", turning, fault(Kind::cut_line, "unit", for_ever, 0.02), {complete}},
      {"UnitSendsNoise", turning, fault(Kind::garbage_byte, "unit", for_ever, 0.02), {complete}},
      {"UnitSendsWrongBits", turning, fault(Kind::crc_error, "unit", for_ever, 0.02), {complete}},
      {"UnitSendsWrongBitsOnly", turning, fault(Kind::crc_error, "unit", for_ever, 1.0), {failed}},
      {"UnitSendsHalfFramesOnly", turning, fault(Kind::cut_line, "unit", for_ever, 1.0), {failed}},
      {"UnitLosesFrames", turning, fault(Kind::lost_frames, "unit", for_ever, 0.02), {complete}},
      {"UnitRepeatsFrames", turning, fault(Kind::duplicated_frames, "unit", for_ever, 0.02), {complete}},
      {"UnitSendsInAnotherOrder", turning, fault(Kind::reordered_frames, "unit", for_ever, 0.02), {complete}},
      {"ChannelFrozen", turning, fault(Kind::frozen_channel, "rotation", for_ever), {complete}},
      {"StatusFails", turning, fault(Kind::status_fails, "", for_ever), {complete}},
      {"CounterWraps", turning, fault(Kind::counter_wraps, "", {}, 10.0), {complete}},
      {"ClockSteps", turning, fault(Kind::clock_steps, "", {}, 1.5), {complete}},
      {"UnitReboots", turning, fault(Kind::unit_reboots, "", {}, 2.0), {complete}},
  };
}

std::vector<FaultCase> axes() {
  using Kind = FaultKind;
  return {
      {"ReadingFrozen", turning, fault(Kind::frozen_reading, "table", for_ever), {faulted}},
      {"TableStuck", turning, fault(Kind::stuck_rate, "table", for_ever), {faulted}},
      {"TableRefuses", turning, fault(Kind::refused_command, "table", for_ever), {faulted}},
      {"TableRefusesForAWhile", turning, fault(Kind::refused_command, "table", 100.0), {stopped, faulted, complete}},
      {"TableDrifts", turning, fault(Kind::drifting_rate, "table", for_ever, 1e-3), {stopped}},
      {"TableDriftsAndRecovers", turning, fault(Kind::drifting_rate, "table", 20.0, 1e-3), {complete}},
      {"TableTrips", turning, fault(Kind::limit_trip, "table"), {stopped}},
      {"TableGoesBeside", turning, fault(Kind::wrong_set_point, "table", for_ever, degree), {stopped}},
      {"TableSwings", turning, fault(Kind::never_settles, "table", 15.0, degree), {complete}},
      {"HeadOvershoots", heading, fault(Kind::overshoot, "head", for_ever, 2.0 * degree), {complete}},
      {"HeadSwings", heading, fault(Kind::never_settles, "head", 15.0, degree), {complete}},
      {"HeadGoesBeside", heading, fault(Kind::wrong_set_point, "head", for_ever, degree), {stopped}},
      {"ChamberSlow", soaking, fault(Kind::chamber_slow, "chamber", for_ever, 0.1), {complete}},
      {"ChamberAlarm", soaking, fault(Kind::chamber_alarm, "chamber", for_ever), {stopped}},
      {"ChamberLost", soaking, fault(Kind::half_open, "chamber", for_ever), {stopped, faulted}},
      {"ChamberSwings", soaking, fault(Kind::never_settles, "chamber", 3600.0, 3.0), {complete}},
  };
}

std::vector<FaultCase> all_cases() {
  std::vector<FaultCase> all = links_of_the_table();
  for (auto& one : instruments()) all.push_back(std::move(one));
  for (auto& one : axes()) all.push_back(std::move(one));
  return all;
}

class RehearsedFault : public ::testing::TestWithParam<FaultCase> {};

TEST_P(RehearsedFault, EndsAsExpectedAndLeavesTheRigSafe) {
  const FaultCase& one = GetParam();
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = one.plan();
  rehearsal.folder = scratch.file("run");
  rehearsal.faults = {one.fault};
  std::string notes;
  rehearsal.company.note = [&](const Note& note, double time) {
    notes += std::to_string(time) + " " + std::string(name(note.kind)) + ": " + note.text.text() + "\n";
  };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_TRUE(one.ends.contains(rehearsed.end.ending))
      << name(rehearsed.end.ending) << ": " << rehearsed.end.text.text() << "\n"
      << notes.substr(0, 3000);
  if (rehearsed.end.ending == RunEnding::faulted)
    EXPECT_NE(rehearsed.end.text.text().find("THE RIG IS NOT SAFE"), std::string::npos) << "a person is told";
  else
    for (const auto& [axis, reading] : rehearsed.axes)
      if (axis != "temperature" && axis != "chamber") {
        EXPECT_LE(std::abs(reading.rate), at_rest) << axis << "\n" << notes.substr(0, 3000);
      }
}

INSTANTIATE_TEST_SUITE_P(All, RehearsedFault, ::testing::ValuesIn(all_cases()),
                         [](const auto& one) { return std::string(one.param.name); });

/// It never settles where it was asked to go. The station waits half an hour for it, eight times.
TEST(RehearsedFaults, AChamberAtAnotherTemperatureThanAskedStopsTheRunAndIsNamed) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = soaking();
  rehearsal.station = station_for(rehearsal.plan);
  rehearsal.station->axes.front().settle.timeout = 1800.0;
  rehearsal.station->file = scratch.file("station.toml");
  std::ofstream(scratch.file(std::string(made_frames_name))) << frames_for(rehearsal.plan);
  rehearsal.folder = scratch.file("run");
  rehearsal.faults = {fault(FaultKind::wrong_set_point, "chamber", for_ever, 5.0)};
  std::string notes;
  rehearsal.company.note = [&](const Note& note, double) { notes += note.text.text() + "\n"; };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, stopped) << rehearsed.end.text.text();
  // the air departs from its set point by 0.1 K, one standard deviation
  EXPECT_NE(notes.find("chamber has not settled within 1800 s: it reads "), std::string::npos) << notes;
  EXPECT_NE(notes.find(" K from the demand, the tolerance is 0.5 K"), std::string::npos) << notes;
  EXPECT_NEAR(rehearsed.axes.at("chamber").value, 273.15 - 15.0, 0.5);
}

TEST(RehearsedFaults, EveryKindHasACase) {
  std::set<FaultKind> tested;
  for (const FaultCase& one : all_cases()) tested.insert(one.fault.kind);
  for (const FaultRule& rule : fault_rules()) EXPECT_TRUE(tested.contains(rule.kind)) << rule.name;
}

}  // namespace
}  // namespace tumble::rehearse_faults_test
