// Streams that commands start: of a rig that stays silent until it has got them, with replies that may be lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/rehearsal/virtual_bench.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/rehearsal/virtual_switch.hpp"
#include "tumble/station/talk_to.hpp"
#include "tumble/station/testing/executive_bench.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

const std::string toml_of_commands =
    "start = [{send = \"=CONFIG,1\\n\", expect = \"CONFIG,1\"}, {send = \"=FMT,A\\n\"}, {send = \"=CONFIG,0\\n\", "
    "expect = \"CONFIG,0\"}]\nstop = [{send = \"=CONFIG,1\\n\"}, {send = \"=OFF\\n\"}]\n";

const FrameLink three_commands{.start = {{"one\n", "ok 1"}, {"two\n", ""}, {"three\n", "ok 3"}},
                               .stop = {{"halt\n", ""}}};

TEST(VirtualSwitch, StreamsAfterAllCommandsInTheirOrder) {
  VirtualSwitch instrument(three_commands);
  EXPECT_FALSE(instrument.streams());
  EXPECT_EQ(instrument.receive("on"), "");
  EXPECT_EQ(instrument.receive("e\n"), "ok 1");
  EXPECT_EQ(instrument.receive("three\n"), "ok 3") << "it answers, and waits for the second";
  EXPECT_FALSE(instrument.streams());
  EXPECT_EQ(instrument.receive("one\ntwo\nnonsense\nthree\n"), "ok 1ok 3");
  EXPECT_TRUE(instrument.streams());
  instrument.receive("halt\n");
  EXPECT_FALSE(instrument.streams());
  EXPECT_TRUE(VirtualSwitch(FrameLink()).streams());
}

/// Two rates, 10 s each, and a unit whose stream is started by commands.
Rehearsal commanded_rehearsal(const ScratchFolder& scratch, const std::string& plan = "gyro_scale_factor") {
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + plan + ".toml", {});
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  Station station = station_for(rehearsal.plan);
  station.file = scratch.file("station.toml");
  station.instruments[0].start = true;
  std::ofstream(scratch.file(std::string(made_frames_name))) << toml_of_commands << frames_for(rehearsal.plan);
  rehearsal.station = station;
  return rehearsal;
}

void shorten(Rehearsal& rehearsal) {
  rehearsal.plan.schedule.resize(2);
  for (Segment& segment : rehearsal.plan.schedule) segment.duration = 10.0;
}

/// What was sent on links that streams come from.
std::string sent_to_units(const std::string& run) {
  std::string sent;
  visit_store(run, [&](const StoreItem& item) {
    if (item.kind == StoreItem::Kind::raw && item.direction == StoreDirection::sent && item.bytes.starts_with("="))
      sent += item.bytes;
  });
  return sent;
}

std::size_t times_in(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

TEST(StreamStart, AUnitThatIsSilentUntilItIsStartedIsRecorded) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch);
  shorten(rehearsal);
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  const std::string start = "=CONFIG,1\n=FMT,A\n=CONFIG,0\n";
  EXPECT_EQ(sent_to_units(rehearsal.folder), start + "=CONFIG,1\n=OFF\n");
  const Recording recording = read_recording(rehearsal.recording, {}, {});
  EXPECT_EQ(recording.marks.size(), 2u);
  for (const Finding& finding : recording.findings) EXPECT_EQ(finding.code, "") << "answers are no garbage";
}

TEST(StreamStart, ItIsStartedAgainInEachPowerUp) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch, "fog_thermal_bias");
  constexpr int power_ups = 2;  // of the plan's, which soak for hours
  std::erase_if(rehearsal.plan.schedule, [](const Segment& segment) { return segment.run > power_ups; });
  for (Segment& segment : rehearsal.plan.schedule) segment.duration = std::min(segment.duration, 20.0);
  ASSERT_EQ(rehearsal.plan.schedule.back().run, power_ups);
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  EXPECT_EQ(times_in(sent_to_units(rehearsal.folder), "=CONFIG,0\n"), static_cast<std::size_t>(power_ups));
  for (const Finding& finding : read_recording(rehearsal.recording, {}, {}).findings)
    EXPECT_TRUE(finding.severity == Finding::Severity::info) << finding.code;
}

TEST(StreamStart, WhereItIsNotWantedNothingIsSentAndTheUnitIsMissed) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch);
  shorten(rehearsal);
  rehearsal.station->instruments[0].start = false;
  EXPECT_EQ(rehearse(rehearsal).end.ending, RunEnding::complete) << "the virtual unit streams already";
  EXPECT_EQ(sent_to_units(rehearsal.folder), "");
}

TEST(StreamStart, AUnitThatIsNotStartedDropsOutBeforeAnythingMoves) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch);
  shorten(rehearsal);
  std::erase_if(rehearsal.station->devices, [](const StationDevice& device) { return device.name == "supply"; });
  std::erase_if(rehearsal.station->safe,
                [](const SafeCommand& command) { return command.request.verb == ControllerVerb::off; });
  rehearsal.station->power.device.reset();
  rehearsal.faults = {
      {.kind = FaultKind::half_open, .name = "cable", .about = "unit", .at = 0.0, .lasts = 1e9, .ends = "failed"}};
  bool moved = false;
  std::string notes;
  rehearsal.company.note = [&](const Note& note, double) {
    moved = moved || note.text.text().ends_with("-> moving");
    notes += std::string(name(note.kind)) + ": " + note.text.text() + "\n";
  };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::failed) << rehearsed.end.text.text();
  EXPECT_FALSE(moved) << notes;
  EXPECT_NE(notes.find("its stream has not started within 30 s"), std::string::npos) << notes;
  EXPECT_NE(notes.find("did not answer '=CONFIG,1.' with 'CONFIG,1' within 2 s"), std::string::npos) << notes;
}

TEST(StreamStart, TheSafeStopStopsTheStream) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch);
  rehearsal.plan.schedule.resize(2);  // of a minute
  rehearsal.faults = {
      {.kind = FaultKind::limit_trip, .name = "it", .about = "table", .at = 45.0, .lasts = 1e9, .ends = "stopped"}};
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_NE(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  EXPECT_TRUE(sent_to_units(rehearsal.folder).ends_with("=CONFIG,1\n=OFF\n")) << sent_to_units(rehearsal.folder);
}

TEST(StreamStart, ACheckStartsASilentStreamAndStopsItAgain) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch);
  Station station = *rehearsal.station;
  station.power.device.reset();
  const StationParts parts = parts_of(station);
  VirtualBench bench(rehearsal.plan, station, parts, 1);
  const auto counts = listen_to(station, parts, bench.wires(), 1.0);
  EXPECT_GT(counts.at(0).good, 0u);
  EXPECT_EQ(counts.at(0).skipped_bytes, counts.at(0).bytes - counts.at(0).good_bytes);
  bench.wait(bench.now() + 1.0);
  EXPECT_EQ(listen_to(station, parts, bench.wires(), 0.0).at(0).good, 0u) << "it is silent again";
}

TEST(StreamStart, OfALinkThatOnlyListensIsRefused) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = commanded_rehearsal(scratch);
  rehearsal.station->instruments[0].link = "udp:5000";
  try {
    parts_of(*rehearsal.station);
    FAIL() << "nobody can start it";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("only listens"), std::string::npos) << error.what();
  }
}

/// The executive alone: one unit of two does not start.
TEST(StreamStart, TheOtherUnitsGoOn) {
  auto course = std::make_shared<Course>();
  course->station = testing::bench_station();
  course->station.instruments = {{.slot = "a", .start = true}, {.slot = "b", .start = true}};
  course->units = {{"a", "1"}, {"b", "2"}};
  course->schedule = {testing::bench_segment("one", 5.0, {{"table", {.kind = Motion::Kind::rate, .value = 0.1}}})};
  testing::ExecutiveBench bench(course);
  bench.at(3.0, StreamStarted{"b"});
  bench.at(4.0, StreamStarted{"nobody"});
  EXPECT_EQ(bench.run(1e4), RunEnding::complete);
  EXPECT_EQ(bench.state.units_out, std::vector<std::string>{"a"});
  EXPECT_GE(bench.phase_began.at("ready"), 30.0);
}

}  // namespace
}  // namespace tumble
