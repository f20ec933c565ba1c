// Plans carried out on virtual rigs over the protocols of their stations, recorded, sealed and identified.
#include "tumble/rehearsal/rehearse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/testing/asserts.hpp"

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
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
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
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"table"}, .pattern = "no device of the station moves"},
                      [&] { rehearse(rehearsal); }));
  EXPECT_FALSE(std::filesystem::exists(rehearsal.folder));
}

}  // namespace
}  // namespace tumble
