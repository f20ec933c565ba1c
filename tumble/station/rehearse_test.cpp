// Plans carried out on virtual rigs over the protocols of their stations, recorded, sealed and identified.
#include "tumble/station/rehearse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/station/made_station.hpp"
#include "tumble/station/run_plan.hpp"
#include "tumble/station/serve_bench.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

const std::string plans = TUMBLE_SOURCE_DIR "/plans/";

Plan plan_named(const std::string& name) { return load_plan(plans + name + ".toml", {}); }

Rehearsal rehearsal_of(const std::string& name, const ScratchFolder& scratch) {
  Rehearsal rehearsal;
  rehearsal.plan = plan_named(name);
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  return rehearsal;
}

const Parameter& parameter(const Estimate& estimate, const std::string& name) {
  return *std::ranges::find(estimate.parameters, name, &Parameter::name);
}

double sd_of(const Estimate& estimate, const std::string& name) {
  const auto index = static_cast<std::size_t>(&parameter(estimate, name) - estimate.parameters.data());
  return std::sqrt(estimate.covariance(index, index));
}

TEST(Rehearse, AScaleFactorTestEndsCompleteAndFindsTheTruth) {
  const ScratchFolder scratch;
  const Rehearsal rehearsal = rehearsal_of("gyro_scale_factor", scratch);
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text;
  ASSERT_EQ(rehearsed.recordings.size(), 1u);

  const Recording recording = read_recording(rehearsal.recording, {}, {});
  std::multiset<std::string> recorded, planned;
  for (const Mark& mark : recording.marks) recorded.insert(mark.label);
  for (const Segment& segment : rehearsal.plan.schedule) planned.insert(segment.label);
  EXPECT_EQ(recorded, planned);

  const Estimate found = identify(rehearsal.plan, {rehearsal.recording}, std::size_t{1} << 30, {});
  const double truth = rehearsal.plan.truth.number("scale_factor") * (1.0 + 15e-6);
  EXPECT_NEAR(parameter(found, "scale_factor").value, truth, 4.0 * sd_of(found, "scale_factor"));
}

TEST(Rehearse, TheSameSeedGivesTheSameRecording) {
  const ScratchFolder first, second;
  const auto one = rehearse(rehearsal_of("gyro_scale_factor", first)),
             other = rehearse(rehearsal_of("gyro_scale_factor", second));
  EXPECT_EQ(one.recordings.at(0).sha256, other.recordings.at(0).sha256);
}

TEST(Rehearse, ALinkThatIsCutEndsTheRunSafely) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = rehearsal_of("gyro_scale_factor", scratch);
  rehearsal.faults = {
      {.kind = FaultKind::drop_link, .name = "cable", .about = "table", .at = 200.0, .ends = "faulted"}};
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_NE(rehearsed.end.ending, RunEnding::complete);
  EXPECT_LT(rehearsed.simulated, 230.0);
  EXPECT_FALSE(rehearsed.recordings.empty()) << "what was recorded is kept";
}

TEST(Rehearse, FaultsAtRandomComeToAnEnd) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = rehearsal_of("gyro_scale_factor", scratch);
  rehearsal.plan.schedule.resize(2);
  rehearsal.faults = {
      {.kind = FaultKind::lost_frames, .about = "unit", .random = 0.1, .lasts = 1.0, .by = 0.5, .ends = "complete"}};
  EXPECT_EQ(rehearse(rehearsal).end.ending, RunEnding::complete);
}

TEST(Rehearse, ARefusedOneLeavesNoFolder) {
  const ScratchFolder scratch;
  Rehearsal rehearsal = rehearsal_of("gyro_scale_factor", scratch);
  rehearsal.station = load_station(TUMBLE_SOURCE_DIR "/stations/sine_vibration.toml");
  EXPECT_THROW(rehearse(rehearsal), Error);
  EXPECT_FALSE(std::filesystem::exists(rehearsal.folder));
}

std::string free_address() {
  Links links([] { return 0.0; });
  return "tcp:127.0.0.1:" + std::to_string(links.listen(0));
}

TEST(Rehearse, APlanIsCarriedOutOverTcp) {
  const ScratchFolder scratch;
  Plan plan = plan_named("gyro_scale_factor");
  plan.schedule.resize(2);
  for (Segment& segment : plan.schedule) segment.duration = 5.0;
  Station station = station_for(plan);
  station.file = scratch.file("station.toml");
  std::ofstream(scratch.file(std::string(made_frames_name))) << frames_for(plan);
  for (StationDevice& device : station.devices) device.link = free_address();
  for (StationInstrument& instrument : station.instruments) instrument.link = free_address();
  const StationParts parts = parts_of(station);
  const auto steady = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  constexpr double speed = 20.0;
  const double begin = steady();
  VirtualBench bench(plan, station, parts, 1);
  BenchServer server(
      bench, station, [&] { return speed * (steady() - begin); }, speed);
  std::atomic<bool> stop{false};
  std::thread serving([&] { server.serve(stop); });

  PlannedRunAtStation run;
  run.plan = plan;
  run.station = station;
  run.folder = scratch.file("run");
  run.units = {{"unit", "7"}};
  run.who = "a test";
  run.date = "2026-11-24";
  run.speed = speed;
  run.clock = steady;
  const RunEnd end = run_plan(run);
  stop = true;
  serving.join();
  EXPECT_EQ(end.ending, RunEnding::complete) << end.text;
  Disk disk;
  const auto sealed = seal(run.folder, disk);
  ASSERT_EQ(sealed.size(), 1u);
  EXPECT_EQ(read_recording(sealed[0].path, {}, {}).marks.size(), 2u);
}

}  // namespace
}  // namespace tumble
