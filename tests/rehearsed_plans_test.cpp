// Every plan that one recording answers: its rehearsal over the protocols of a station gives the answer of its
// simulation.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

/// What the method finds in the recording of a rehearsal at the station that is made for the plan.
Estimate rehearsed_result(const Plan& plan, const ScratchFolder& scratch, std::uint64_t seed) {
  Rehearsal rehearsal;
  rehearsal.plan = plan;
  rehearsal.seed = seed;
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  std::string notes;
  rehearsal.company.note = [&](const Note& note, double) {
    notes += std::string(name(note.kind)) + ": " + note.text.text() + "\n";
  };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text() << "\n" << notes.substr(0, 2000);
  return identify(plan, {rehearsal.recording}, std::size_t{1} << 30, {});
}

/// Rig, noise and instrument of the two are drawn independently, so that their variances add up.
void expect_same_answer(const std::string& name, std::uint64_t seed) {
  const ScratchFolder scratch;
  const Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + name + ".toml", {});
  const Estimate rehearsed = rehearsed_result(plan, scratch, seed);
  const Estimate simulated = identify({plan, {simulate(plan, seed + 100, {})}}, {});
  std::size_t compared = 0;
  for (std::size_t p = 0; p < rehearsed.parameters.size(); ++p) {
    const Parameter& one = rehearsed.parameters[p];
    const auto other = std::ranges::find(simulated.parameters, one.name, &Parameter::name);
    if (other == simulated.parameters.end()) continue;
    const auto q = static_cast<std::size_t>(other - simulated.parameters.begin());
    const double variance = rehearsed.covariance(p, p) + simulated.covariance(q, q);
    if (!(variance > 0.0)) continue;
    EXPECT_NEAR(one.value, other->value, 4.0 * std::sqrt(variance)) << one.name;
    ++compared;
  }
  EXPECT_GT(compared, 0u);
}

class RehearsedPlan : public ::testing::TestWithParam<const char*> {};

TEST_P(RehearsedPlan, GivesTheAnswerOfASimulation) { expect_same_answer(GetParam(), 1); }

INSTANTIATE_TEST_SUITE_P(Plans, RehearsedPlan,
                         ::testing::Values("accelerometer_centrifuge", "imu_ferraris", "imu_multi_position",
                                           "north_finding"),
                         [](const auto& plan) { return std::string(plan.param); });

/// All others, with other seeds, where the tests may take long.
class RehearsedPlanCoverage : public ::testing::TestWithParam<const char*> {};

TEST_P(RehearsedPlanCoverage, GivesTheAnswerOfASimulation) {
  const char* seeds = std::getenv("TUMBLE_COVERAGE_SEEDS");
  if (!seeds || std::atoi(seeds) < 400) GTEST_SKIP() << "in script/test --full";
  for (const std::uint64_t seed : {2u, 3u}) expect_same_answer(GetParam(), seed);
}

INSTANTIATE_TEST_SUITE_P(Plans, RehearsedPlanCoverage,
                         ::testing::Values("accelerometer_centrifuge", "accelerometer_dynamic",
                                           "accelerometer_four_position", "accelerometer_tumble", "dtg_centrifuge",
                                           "fog_thermal_bias", "frequency_response", "gyro_scale_factor",
                                           "imu_ferraris", "imu_multi_position", "imu_turntable", "imu_turntable_short",
                                           "north_finding", "north_finding_turning", "polar_axis_tumble", "rlg_lock_in",
                                           "rlg_north_finder", "sdof_gyro_centrifuge", "sdof_gyro_dynamic",
                                           "sdof_gyro_static", "sine_vibration"),
                         [](const auto& plan) { return std::string(plan.param); });

}  // namespace
}  // namespace tumble
