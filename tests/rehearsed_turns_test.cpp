// Plans that turn or oscillate, carried out on virtual rigs: the table is brought to its motion before the recording
// begins, at any angle, and the encoder's phase must lead to the truth of the plan.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

class RehearsedTurns : public ::testing::TestWithParam<const char*> {};

TEST_P(RehearsedTurns, LeadToTheTruthOfThePlan) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + std::string(GetParam()) + ".toml", {});
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();

  const Plan& plan = rehearsal.plan;
  const Estimate found = identify(plan, {rehearsal.recording}, std::size_t{1} << 30, {});
  EXPECT_TRUE(std::ranges::any_of(found.findings, [](const Finding& f) { return f.code == "turn_phase_recorded"; }));
  std::size_t compared = 0;
  for (std::size_t p = 0; p < found.parameters.size(); ++p) {
    const std::string& name = found.parameters[p].name;
    const bool azimuth = name == "azimuth";
    if (!azimuth && !plan.truth.has(name)) continue;
    double truth = azimuth ? plan.settings.number("reference_azimuth") : plan.truth.number(name);
    for (const auto& term : found.parameters[p].contains)
      if (plan.truth.has(term.name)) truth += term.weight * plan.truth.number(term.name);
    EXPECT_NEAR(found.parameters[p].value, truth, 4.0 * std::sqrt(found.covariance(p, p))) << name;
    ++compared;
  }
  EXPECT_GE(compared, 3u);
}

INSTANTIATE_TEST_SUITE_P(Plans, RehearsedTurns,
                         ::testing::Values("north_finding_turning", "accelerometer_dynamic", "sdof_gyro_centrifuge",
                                           "sdof_gyro_dynamic", "imu_turntable_short"),
                         [](const auto& plan) { return std::string(plan.param); });

}  // namespace
}  // namespace tumble
