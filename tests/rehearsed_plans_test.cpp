// Every plan that one recording answers: what its rehearsal identifies is what its simulation must identify, the truth of
// the plan.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/station/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

/// The plan carried out at the station that is made for it. Each parameter lies within four standard deviations of what
/// the truth makes of it, which the prediction states.
void expect_truth(const std::string& name, std::uint64_t seed) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + name + ".toml", {});
  rehearsal.seed = seed;
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text;
  const Estimate found = identify(rehearsal.plan, {rehearsal.recording}, std::size_t{1} << 30, {});
  const Estimate truth = predict(rehearsal.plan);
  std::size_t compared = 0;
  for (std::size_t p = 0; p < found.parameters.size(); ++p) {
    const Parameter& one = found.parameters[p];
    const auto stated = std::ranges::find(truth.parameters, one.name, &Parameter::name);
    const double sd = std::sqrt(found.covariance(p, p));
    if (stated == truth.parameters.end() || !std::isfinite(stated->value) || !(sd > 0.0)) continue;
    EXPECT_NEAR(one.value, stated->value, 4.0 * sd) << one.name;
    ++compared;
  }
  EXPECT_GT(compared, 0u);
}

class RehearsedPlan : public testing::TestWithParam<const char*> {};

TEST_P(RehearsedPlan, LeadsToTheTruthOfThePlan) { expect_truth(GetParam(), 1); }

INSTANTIATE_TEST_SUITE_P(Plans, RehearsedPlan,
                         testing::Values("accelerometer_centrifuge", "imu_ferraris", "imu_multi_position",
                                         "north_finding", "triad_six_faces"),
                         [](const auto& plan) { return std::string(plan.param); });

/// All others, with other seeds, where the tests may take long.
class RehearsedPlanCoverage : public testing::TestWithParam<const char*> {};

TEST_P(RehearsedPlanCoverage, LeadsToTheTruthOfThePlan) {
  const char* seeds = std::getenv("TUMBLE_COVERAGE_SEEDS");
  if (!seeds || std::atoi(seeds) < 400) GTEST_SKIP() << "in script/test --full";
  for (const std::uint64_t seed : {2u, 3u}) expect_truth(GetParam(), seed);
}

INSTANTIATE_TEST_SUITE_P(Plans, RehearsedPlanCoverage,
                         testing::Values("accelerometer_centrifuge", "accelerometer_dynamic",
                                         "accelerometer_four_position", "accelerometer_tumble", "dtg_centrifuge",
                                         "fog_thermal_bias", "frequency_response", "gyro_scale_factor", "imu_ferraris",
                                         "imu_multi_position", "imu_turntable", "imu_turntable_short", "north_finding",
                                         "north_finding_turning", "polar_axis_tumble", "rlg_lock_in",
                                         "rlg_north_finder", "sdof_gyro_centrifuge", "sdof_gyro_dynamic",
                                         "sdof_gyro_static", "sine_vibration", "triad_six_faces"),
                         [](const auto& plan) { return std::string(plan.param); });

}  // namespace
}  // namespace tumble
