// What the shell around the executive does for people: orders before the begin, and displays that fail.
#include "tumble/station/carry_out.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <set>
#include <thread>

#include "tumble/checks/check.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Two rates, 10 s each.
Rehearsal short_rehearsal(const ScratchFolder& scratch) {
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  rehearsal.plan.schedule.resize(2);
  for (Segment& segment : rehearsal.plan.schedule) segment.duration = 10.0;
  rehearsal.folder = scratch.file("run");
  rehearsal.company.ask = [](const Prompt&) {};
  return rehearsal;
}

/// This is how a run is taken over from one that was killed: the table may turn, and nothing is enabled before it
/// stands.
TEST(CarryOut, AStopThatWasOrderedBeforeTheBeginPreparesNothing) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = short_rehearsal(scratch);
  rehearsal.company.orders = [told = false]() mutable {
    std::vector<decltype(RunEvent::what)> orders;
    if (!std::exchange(told, true)) orders.push_back(RunOrder{RunOrder::Kind::stop, "takeover"});
    return orders;
  };
  EXPECT_EQ(rehearse(rehearsal).end.ending, RunEnding::stopped);
  std::set<std::string> sent;
  visit_store(rehearsal.folder, [&](const StoreItem& item) {
    if (item.kind == StoreItem::Kind::raw && item.direction == StoreDirection::sent) sent.emplace(item.bytes);
  });
  EXPECT_TRUE(sent.contains("STOP\n"));
  for (const std::string& bytes : sent) {
    const bool harmless = bytes == "STOP\n" || bytes == "OUTP OFF\n" || bytes.find('?') != std::string::npos;
    EXPECT_TRUE(harmless && bytes != "*IDN?\n") << bytes;
  }
}

TEST(CarryOut, ADisplayThatFailsDoesNotEndTheRun) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = short_rehearsal(scratch);
  rehearsal.company.ask = {};
  int shown = 0;
  const auto fail = [&] {
    ++shown;
    throw Error(Error::Kind::bad_file, "standard output: the pipe has no reader");
  };
  rehearsal.company.note = [&](const Note&, double) { fail(); };
  rehearsal.company.show = [&](const RunView&) { fail(); };
  EXPECT_EQ(rehearse(rehearsal).end.ending, RunEnding::complete);
  EXPECT_GT(shown, 10);
}

/// [s] when the segments of a rehearsal that goes well are recorded.
std::vector<double> begins_of_segments(Rehearsal rehearsal) {
  std::vector<double> begins;
  rehearsal.company.note = [&](const Note& note, double time) {
    if (note.kind == EventKind::records) begins.push_back(time);
  };
  rehearse(rehearsal);
  return begins;
}

/// The link of the unit stays open, and nothing comes from `time` [s] on.
VirtualFault silence_from(double time) {
  return {.kind = FaultKind::half_open, .name = "it", .about = "unit", .at = time, .lasts = 1e9, .ends = "complete"};
}

/// The unit falls silent while it is recorded; segments of 2 s are shorter than a silence of 5 s.
TEST(CarryOut, ASilenceGoesOnFromOneSegmentToTheNext) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = short_rehearsal(scratch);
  rehearsal.company.ask = {};
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  rehearsal.plan.schedule.resize(6);
  for (Segment& segment : rehearsal.plan.schedule) segment.duration = 2.0;
  const std::vector<double> begins = begins_of_segments(rehearsal);
  ASSERT_EQ(begins.size(), 6u);
  const ScratchFolder second;
  rehearsal.folder = second.file("run");
  rehearsal.faults = {silence_from(begins[1] + 1.0)};
  std::string notes;
  rehearsal.company.note = [&](const Note& note, double) { notes += note.text.text() + "\n"; };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::failed) << rehearsed.end.text.text();
  EXPECT_NE(notes.find("no sample was received for"), std::string::npos) << notes;
  EXPECT_LT(rehearsed.simulated, begins[5]) << "before the last segment";
}

/// It falls silent so late that the plan is carried out before the silence is too long.
TEST(CarryOut, ASilenceAtTheEndIsSaid) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = short_rehearsal(scratch);
  rehearsal.company.ask = {};
  const double began = begins_of_segments(rehearsal).back();
  const ScratchFolder second;
  rehearsal.folder = second.file("run");
  rehearsal.faults = {silence_from(began + 7.0)};
  std::vector<std::string> notes;
  rehearsal.company.note = [&](const Note& note, double) { notes.push_back(note.text); };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  EXPECT_TRUE(std::ranges::any_of(notes, [](const std::string& text) {
    return text.find("no sample was received in the last") != std::string::npos;
  }));
  const Recording recording = read_recording(rehearsed.recordings.at(0).path, {}, {});
  EXPECT_TRUE(std::ranges::any_of(run_checks(recording, nullptr),
                                  [](const Finding& finding) { return finding.code == "samples_end_early"; }));
}

/// Nobody looks at interlocks while the process waits for the disk.
TEST(CarryOut, ADiskThatDoesNotAnswerEndsTheRunSafely) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = short_rehearsal(scratch);
  rehearsal.company.ask = {};
  rehearsal.company.longest_commit = 0.0;
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::stopped) << rehearsed.end.text.text();
  EXPECT_NE(rehearsed.end.text.text().find("the disk has not answered for 0 s"), std::string::npos)
      << rehearsed.end.text.text();
  EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), 1e-4);
}

/// A person tidies up while the run goes on.
TEST(CarryOut, AStoreThatIsRemovedEndsTheRunAtOnceAndSafely) {
  for (const char* name : {"live.sqlite", "live.sqlite-wal"}) {
    const ScratchFolder scratch;
    Rehearsal rehearsal = short_rehearsal(scratch);
    rehearsal.company.ask = {};
    double removed = -1.0;
    rehearsal.company.note = [&](const Note& note, double time) {
      if (note.kind == EventKind::records && removed < 0.0) {
        EXPECT_TRUE(std::filesystem::remove(std::filesystem::path(rehearsal.folder) / name)) << name;
        removed = time;
      }
    };
    try {
      const Rehearsed rehearsed = rehearse(rehearsal);
      EXPECT_NE(rehearsed.end.ending, RunEnding::complete);
      EXPECT_NE(rehearsed.end.text.text().find("was removed or replaced"), std::string::npos)
          << rehearsed.end.text.text();
      EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), 1e-4);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("live.sqlite"), std::string::npos) << "there is nothing to seal";
    }
    EXPECT_GE(removed, 0.0);
  }
}

TEST(CarryOut, AFlushEndsWhenTheDiskTakesTooLong) {
  const ScratchFolder scratch;
  Disk disk;
  RecorderOptions options;
  options.reserve_bytes = 0;
  options.on_commit = [](const Acknowledged&) { std::this_thread::sleep_for(std::chrono::milliseconds(300)); };
  Recorder recorder(scratch.path, disk, options);
  recorder.event({1.0, EventKind::notice, {}, "it", {}});
  EXPECT_FALSE(recorder.flush(0.01));
  EXPECT_FALSE(recorder.failure());
  EXPECT_TRUE(recorder.flush()) << "it was late, and it is there";
}

}  // namespace
}  // namespace tumble
