// What the shell around the executive does for people: orders before the begin, and displays that fail.
#include "tumble/station/carry_out.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/station/recorder_read.hpp"
#include "tumble/station/rehearse.hpp"
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

/// Nobody looks at interlocks while the process waits for the disk.
TEST(CarryOut, ADiskThatDoesNotAnswerEndsTheRunSafely) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = short_rehearsal(scratch);
  rehearsal.company.ask = {};
  rehearsal.company.longest_commit = 0.0;
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::stopped) << rehearsed.end.text;
  EXPECT_NE(rehearsed.end.text.find("the disk has not answered for 0 s"), std::string::npos) << rehearsed.end.text;
  EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), 1e-4);
}

TEST(CarryOut, AFlushEndsWhenTheDiskTakesTooLong) {
  const ScratchFolder scratch;
  Disk disk;
  RecorderOptions options;
  options.reserve_bytes = 0;
  options.on_commit = [](const Acknowledged&) { std::this_thread::sleep_for(std::chrono::milliseconds(300)); };
  Recorder recorder(scratch.path, disk, options);
  recorder.event({1.0, "note", {}, "it", {}});
  EXPECT_FALSE(recorder.flush(0.01));
  EXPECT_FALSE(recorder.failure());
  EXPECT_TRUE(recorder.flush()) << "it was late, and it is there";
}

}  // namespace
}  // namespace tumble
