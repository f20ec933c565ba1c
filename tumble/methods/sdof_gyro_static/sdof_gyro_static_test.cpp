#include <gtest/gtest.h>

#include <cmath>

#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble {
namespace {

const Method& static_gyro() { return find_method("sdof_gyro_static"); }

// One degree is 360 times what the rig states. D_O takes up most of the Earth rate that it moves; the rest shows it
// with F of 100 to 200, so to 10 %: 4 sigma are 144.
TEST(SdofGyroStatic, AnAzimuthOneDegreeOffIsSaid) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Trial trial = trial_of(static_gyro(), seed);
    Plan real = trial.evidence.plan;
    real.rig.set_number("outer_azimuth", real.rig.number("outer_azimuth") + si(1.0, "deg"), Unit::parse("deg"));
    trial.evidence.recordings = {simulate(real, seed, {})};
    const auto findings = static_gyro().identify(trial.evidence, {}).findings;
    EXPECT_NEAR(value_of(findings, "rig_error_beyond_stated", "times"), 360.0, 144.0) << seed;
  }
}

// 1 deg/h that dies away in a fifth of the test to all of it: D_F is up to 8 sd off. The closing position tells.
TEST(SdofGyroStatic, AWarmUpIsSaid) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const double tau : {1200.0, 3600.0}) {
      Trial trial = trial_of(static_gyro(), seed);
      Channel& gyro = trial.evidence.recordings[0].channels[0];
      for (std::size_t i = 0; i < gyro.values.size(); ++i)
        gyro.values[i] += si(1.0, "deg/h") * std::exp(-gyro.time(i) / tau);
      const auto findings = static_gyro().identify(trial.evidence, {}).findings;
      EXPECT_TRUE(has_finding(findings, "output_drifts_with_time")) << tau;
      EXPECT_TRUE(has_finding(findings, "repeats_differ_more_than_positions")) << tau;
    }
}

TEST(SdofGyroStatic, SoundTestsAreNotAccused) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    for (const Trial& trial : {trial_of(static_gyro(), seed), second_trial_of(static_gyro(), seed)}) {
      const auto findings = static_gyro().identify(trial.evidence, {}).findings;
      for (const char* code :
           {"rig_error_beyond_stated", "output_drifts_with_time", "repeats_differ_more_than_positions",
            "positions_differ_more_than_repeats", "output_drifts_within_segments"})
        EXPECT_FALSE(has_finding(findings, code)) << code << ", seed " << seed;
    }
}

}  // namespace
}  // namespace tumble
