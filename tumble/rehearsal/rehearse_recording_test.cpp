// What a rehearsed run leaves on the disk: lost, doubled and broken frames, disks that fail, runs that are killed and
// carried on, operators who are late.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/math/random.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/recorder/testing/faulty_disk.hpp"
#include "tumble/recorder/testing/marks_so_far.hpp"
#include "tumble/recorder/testing/small_run.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::DiskFault;
using testing::FaultyDisk;

/// A table at a few rates up and down.
Plan plan_for_recording(std::size_t segments, double duration) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  plan.schedule.resize(segments);
  for (Segment& segment : plan.schedule) segment.duration = duration;
  return plan;
}

Rehearsal rehearsal_at(const std::string& folder, const Plan& plan) {
  Rehearsal rehearsal;
  rehearsal.plan = plan;
  rehearsal.folder = folder;
  return rehearsal;
}

std::size_t missing_in(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::ranges::count_if(values, [](double value) { return std::isnan(value); }));
}

/// Frames that are lost or broken are missing, each at its place; all others are what they would have been.
void expect_missing_at_their_places(FaultKind kind, double part) {
  const ScratchFolder sound, spoiled;
  const Plan plan = plan_for_recording(2, 60.0);
  auto rehearsal = rehearsal_at(spoiled.file("run"), plan);
  rehearsal.faults = {{.kind = kind, .about = "unit", .at = 5.0, .lasts = 90.0, .by = part, .ends = "complete"}};
  const auto whole = rehearse(rehearsal_at(sound.file("run"), plan)), less = rehearse(rehearsal);
  ASSERT_EQ(less.end.ending, RunEnding::complete) << less.end.text.text();
  const Recording expected = read_recording(whole.recordings.at(0).path, {}, {});
  const Recording found = read_recording(less.recordings.at(0).path, {}, {});
  ASSERT_EQ(found.channels.size(), expected.channels.size());
  std::size_t missing = 0;
  for (std::size_t c = 0; c < found.channels.size(); ++c) {
    const auto& one = found.channels[c].values;
    const auto& other = expected.channels[c].values;
    ASSERT_EQ(one.size(), other.size()) << found.channels[c].name;
    for (std::size_t k = 0; k < one.size(); ++k)
      if (!std::isnan(one[k])) {
        ASSERT_EQ(one[k], other[k]) << found.channels[c].name << " " << k;
      }
    missing = missing_in(one);
  }
  const bool harmless = kind == FaultKind::duplicated_frames;
  EXPECT_EQ(missing > 5, !harmless) << missing;
  std::string codes;
  double lost = 0.0;
  for (const Finding& finding : less.recordings.at(0).findings) {
    codes += finding.code + ": " + finding.message + "\n";
    if (finding.code == "frames_lost")
      for (const auto& value : finding.values)
        if (const auto* count = std::get_if<long long>(&value.value); count && value.name == "lost")
          lost = static_cast<double>(*count);
  }
  EXPECT_EQ(static_cast<std::size_t>(lost), missing) << codes;
  EXPECT_FALSE(codes.empty()) << "nothing is said of it";
}

TEST(RehearsedRecording, LostFramesAreMissingAtTheirPlaces) {
  expect_missing_at_their_places(FaultKind::lost_frames, 0.05);
}
TEST(RehearsedRecording, BrokenFramesAreMissingAtTheirPlaces) {
  expect_missing_at_their_places(FaultKind::crc_error, 0.05);
}
TEST(RehearsedRecording, HalfFramesAreMissingAtTheirPlaces) {
  expect_missing_at_their_places(FaultKind::cut_line, 0.05);
}
TEST(RehearsedRecording, DoubledFramesCountOnce) { expect_missing_at_their_places(FaultKind::duplicated_frames, 0.05); }

TEST(RehearsedRecording, ADiskThatFailsOrIsFullStopsTheRunSafely) {
  const Plan plan = plan_for_recording(2, 60.0);
  for (const auto kind : {DiskFault::Kind::fails, DiskFault::Kind::full})
    for (const std::uint64_t at : {60u, 61u, 62u, 63u, 64u, 65u, 66u}) {
      const ScratchFolder scratch;
      FaultyDisk disk({kind, at, 1});
      auto rehearsal = rehearsal_at(scratch.file("run"), plan);
      rehearsal.disk = &disk.disk();
      const Rehearsed rehearsed = rehearse(rehearsal);
      ASSERT_GE(disk.calls(), at) << "the fault has not happened";
      if (rehearsed.end.ending == RunEnding::complete) continue;  // the tidying up of a checkpoint may fail
      EXPECT_EQ(rehearsed.end.ending, RunEnding::stopped) << rehearsed.end.text.text();
      EXPECT_NE(rehearsed.end.text.text().find("the recording has stopped"), std::string::npos)
          << rehearsed.end.text.text();
      EXPECT_LE(std::abs(rehearsed.axes.at("table").rate), 0.01 * degree);
      const auto items = items_of_store(rehearsal.folder);
      EXPECT_FALSE(items.empty());
    }
}

/// A run whose disk loses power at this call, and which is carried on.
Rehearsed killed_and_resumed(const Plan& plan, std::uint64_t at, const std::string& folder) {
  auto rehearsal = rehearsal_at(folder, plan);
  {
    FaultyDisk disk({DiskFault::Kind::crash, at, at});
    rehearsal.disk = &disk.disk();
    rehearse(rehearsal);
    disk.power_cut();
  }
  rehearsal.disk = nullptr;
  const GivenItems before = items_of_store(folder);
  rehearsal.resume = true;
  const Rehearsed resumed = rehearse(rehearsal);
  const GivenItems after = items_of_store(folder);
  for (const auto& [sequence, item] : before)
    EXPECT_TRUE(after.contains(sequence) && after.at(sequence) == item) << "item " << sequence << ", call " << at;
  double last = -1.0;
  for (const auto& [sequence, item] : after) {
    const bool old = sequence <= before.rbegin()->first;
    if (old) last = std::max(last, item.time);
    EXPECT_TRUE(old || item.time > last) << "the clock goes back, call " << at;
  }
  return resumed;
}

const Parameter& parameter_named(const Estimate& estimate, const std::string& name) {
  return *std::ranges::find(estimate.parameters, name, &Parameter::name);
}

TEST(RehearsedRecording, ARunThatWasKilledIsCarriedOnAndGivesTheSameResult) {
  const char* const wanted = std::getenv("TUMBLE_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 10;
  const ScratchFolder scratch;
  const Plan plan = plan_for_recording(13, 12.0);
  FaultyDisk counted;
  auto whole = rehearsal_at(scratch.file("whole"), plan);
  whole.disk = &counted.disk();
  const auto uninterrupted = rehearse(whole);
  ASSERT_EQ(uninterrupted.end.ending, RunEnding::complete);
  const std::uint64_t first = 40, calls = counted.calls();
  ASSERT_GT(calls, first + 100);
  const auto estimate_of = [&](const Rehearsed& run) {
    return identify(plan, {run.recordings.at(0).path}, std::size_t{1} << 30, {});
  };
  const Estimate expected = estimate_of(uninterrupted);
  const auto index = static_cast<std::size_t>(&parameter_named(expected, "scale_factor") - expected.parameters.data());
  const double sd = std::sqrt(expected.covariance(index, index));
  const RandomStream random(20);
  std::vector<std::uint64_t> kills_at;
  for (int kill = 0; kill < kills; ++kill)
    kills_at.push_back(first + static_cast<std::uint64_t>(random.uniform(static_cast<std::uint64_t>(kill)) *
                                                          static_cast<double>(calls - first - 60)));
  if (wanted)  // script/test --full: each call too
    for (std::uint64_t at = first; at < calls - 60; ++at) kills_at.push_back(at);
  for (const std::uint64_t at : kills_at) {
    const ScratchFolder place;
    const Rehearsed resumed = killed_and_resumed(plan, at, place.file("run"));
    ASSERT_EQ(resumed.end.ending, RunEnding::complete) << "call " << at << ": " << resumed.end.text.text();
    const Recording recording = read_recording(resumed.recordings.at(0).path, {}, {});
    EXPECT_EQ(recording.marks.size(), plan.schedule.size()) << "no segment counts twice, call " << at;
    // Two measurements, each with this uncertainty.
    EXPECT_NEAR(parameter_named(estimate_of(resumed), "scale_factor").value,
                parameter_named(expected, "scale_factor").value, 4.0 * std::sqrt(2.0) * sd)
        << "call " << at;
  }
}

TEST(RehearsedRecording, ASegmentThatCountsHasItsMarksWhereverTheStoreWasCut) {
  const ScratchFolder scratch;
  const auto rehearsal = rehearsal_at(scratch.file("run"), plan_for_recording(3, 12.0));
  ASSERT_EQ(rehearse(rehearsal).end.ending, RunEnding::complete);
  std::vector<RunRow> rows;
  testing::MarksSoFar marked;
  std::size_t most = 0;
  visit_store(rehearsal.folder, [&](const StoreItem& item) {
    if (!item.journal) return;
    marked.add(item.time, *item.journal);
    rows.push_back(*item.journal);
    const std::size_t counted = counted_attempts(rows).size();
    EXPECT_LE(counted, marked.count()) << "cut after item " << item.sequence;
    most = std::max(most, counted);
  });
  EXPECT_EQ(most, 3u);
}

TEST(RehearsedRecording, ALateOperatorFindsTheRigHeldAndGoesOn) {
  const ScratchFolder scratch;
  auto rehearsal = rehearsal_at(scratch.file("run"), plan_for_recording(2, 30.0));
  std::optional<Prompt> open;
  double asked_at = 0.0, now = 0.0;
  bool held = false, late_answer_refused = false;
  rehearsal.company.ask = [&](const Prompt& prompt) {
    open = prompt;
    asked_at = now;
  };
  rehearsal.company.note = [&](const Note& note, double time) {
    now = time;
    held |= note.kind == EventKind::prompt && note.text.text().find("held") != std::string::npos;
    late_answer_refused |= note.kind == EventKind::refused && note.text.text().find("is closed") != std::string::npos;
  };
  rehearsal.company.show_every = 60.0;
  rehearsal.company.show = [&](const RunView& view) { now = view.time; };
  bool answered = false;
  rehearsal.company.orders = [&] {
    std::vector<decltype(RunEvent::what)> orders;
    if (answered && open) orders.push_back(PromptAnswer{open->id, "done", "late again"}), open.reset();
    if (!answered && open && now > asked_at + hour) {
      orders.push_back(PromptAnswer{open->id, "done", "late"});
      answered = true;
    }
    return orders;
  };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  EXPECT_TRUE(held) << "nobody answered, and the rig was not held";
  EXPECT_TRUE(late_answer_refused);
  EXPECT_GT(rehearsed.simulated, hour);
}

TEST(RehearsedRecording, FoldersMayHaveAnyName) {
  const ScratchFolder scratch;
  const auto rehearsed =
      rehearse(rehearsal_at(scratch.file("\xe8\xbd\xac\xe5\x8f\xb0 run 'one' #1"), plan_for_recording(1, 10.0)));
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  ASSERT_EQ(rehearsed.recordings.size(), 1u);
  EXPECT_GT(read_recording(rehearsed.recordings[0].path, {}, {}).channels.size(), 0u);
}

TEST(RehearsedRecording, ADiskThatMayNotBeWrittenIsRefusedBeforeAnythingMoves) {
  const auto attempt = [] { rehearse(rehearsal_at("/proc/no/run", plan_for_recording(1, 10.0))); };
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"/proc/no/run"}}, [&] { attempt(); }));
}

}  // namespace
}  // namespace tumble
