// What was carried out decides: clocks and orders that differ from the plan, asked of the trials of methods.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/departures/departure.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/tasks/departed.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

SimulatedTest test_of(const char* method) {
  Trial trial = trials_of(find_method(method)).first(1);
  return simulated_test(std::move(trial.evidence), std::move(trial.truth), 1);
}

const Departure& departure_called(const std::string& name) {
  const auto& all = departure_catalogue();
  return *std::ranges::find_if(all, [&](const Departure& one) { return one.name == name; });
}

Findings found_in(const SimulatedTest& test) { return identify(test.evidence, {}).findings; }

bool warns_of(const Findings& findings, const char* code) {
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return finding.code == code && finding.severity != Finding::Severity::info;
  });
}

/// 30 ppm between stamps and stated rate are several standard deviations of a scale factor of counts.
TEST(CarriedOut, AScaleFactorOfCountsWarnsOfTwoClocks) {
  const SimulatedTest sound = test_of("accelerometer_tumble");
  EXPECT_FALSE(warns_of(found_in(sound), "rate_of_counts_differs"));
  const auto fast = with_departure(sound, departure_called("clock_fast"), "", 30e-6, 1);
  EXPECT_TRUE(warns_of(found_in(fast), "rate_of_counts_differs"));
}

/// 30 ppm are beyond a rate that the rig states to 1 ppm.
TEST(CarriedOut, ATableThatTurnsByAnotherClockIsNamed) {
  const SimulatedTest sound = test_of("gyro_scale_factor");
  EXPECT_FALSE(warns_of(found_in(sound), "turn_rate_recorded"));
  const auto fast = with_departure(sound, departure_called("clock_fast"), "", 30e-6, 1);
  EXPECT_TRUE(warns_of(found_in(fast), "turn_rate_recorded"));
}

/// Samples that arrive eight at a time were taken one by one. How long the last of them waited nobody knows, which is in the
/// budget.
TEST(CarriedOut, SamplesInBurstsGiveWhatEvenOnesGive) {
  const SimulatedTest sound = test_of("accelerometer_dynamic");
  const auto bursts = with_departure(sound, departure_called("stamps_in_bursts"), "", 0.0, 1);
  const Estimate even = identify(sound.evidence, {}), late = identify(bursts.evidence, {});
  ASSERT_EQ(even.parameters.size(), late.parameters.size());
  for (std::size_t j = 0; j < even.parameters.size(); ++j)
    EXPECT_NEAR(late.parameters[j].value, even.parameters[j].value, 0.5 * standard_uncertainty(late, j))
        << even.parameters[j].name;
}

/// Rounding to whole pulses is less at rest, where the counter hardly moves, than at a rate: that is no other motion.
TEST(CarriedOut, ASoundCounterShowsNoOtherMotion) {
  const Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    EXPECT_FALSE(
        warns_of(identify(Evidence{plan, {simulate(plan, seed, {})}}, {}).findings, "motion_differs_from_model"))
        << seed;
}

/// What is found does not depend on whether the samples come from a file, of which only some columns are read.
TEST(CarriedOut, AFileShowsWhatARecordingInMemoryShows) {
  const ScratchFolder scratch;
  for (const std::string name : {"accelerometer_tumble", "polar_axis_tumble", "gyro_scale_factor"}) {
    const Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/" + name + ".toml", {});
    const auto recordings = simulate_departed(plan, wanted_departures({"encoder_at_rest"}), 1);
    ASSERT_EQ(recordings.size(), 1u) << name;
    const std::string file = scratch.file(name + ".h5");
    write_recording(recordings.front(), file);
    const auto codes = [](const Findings& findings) {
      std::set<std::string> all;
      for (const Finding& finding : findings)
        if (finding.severity != Finding::Severity::info) all.insert(finding.code);
      return all;
    };
    const auto in_memory = codes(identify(Evidence{plan, recordings}, {}).findings);
    EXPECT_EQ(codes(identify(plan, {file}, std::size_t{1} << 30, {}).findings), in_memory) << name;
    EXPECT_FALSE(in_memory.empty()) << name;
  }
}

}  // namespace
}  // namespace tumble
