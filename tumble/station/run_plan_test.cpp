// Plans carried out over real TCP links against a virtual rig that is served at them.
#include "tumble/station/run_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tumble/station/lease.hpp"
#include "tumble/station/recorder_read.hpp"
#include "tumble/station/testing/served_rig.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using testing::run_over_tcp;
using testing::ServedRig;
using testing::station_over_tcp;

constexpr double standing = 0.01 * degree;  ///< [rad/s] what counts as a rate of zero
constexpr double fast = 20.0;  ///< [1] of the clock of the rig

/// Two segments of 5 s, at -120 deg/s and -90 deg/s.
Plan short_plan() {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  plan.schedule.resize(2);
  for (Segment& segment : plan.schedule) segment.duration = 5.0;
  return plan;
}

TEST(RunPlan, APlanIsCarriedOutOverTcp) {
  const ScratchFolder scratch;
  const Plan plan = short_plan();
  const Station station = station_over_tcp(plan, scratch);
  ServedRig rig(plan, station, fast);
  const RunEnd end = run_plan(run_over_tcp(plan, station, scratch.file("run"), fast));
  EXPECT_EQ(end.ending, RunEnding::complete) << end.text;
  EXPECT_LE(std::abs(rig.end().at("table").rate), standing);
  Disk disk;
  const auto sealed = seal(scratch.file("run"), disk);
  ASSERT_EQ(sealed.size(), 1u);
  const Recording recording = read_recording(sealed[0].path, {}, {});
  EXPECT_EQ(recording.marks.size(), 2u);
}

TEST(RunPlan, ASecondRunOnTheSameRigIsRefusedBeforeAnythingMoves) {
  const ScratchFolder scratch;
  const Plan plan = short_plan();
  const Station station = station_over_tcp(plan, scratch);
  ServedRig rig(plan, station, fast);
  Lease first(station, scratch.file("first"));
  auto second = run_over_tcp(plan, station, scratch.file("second"), fast);
  try {
    run_plan(second);
    FAIL() << "two runs on one rig";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("is in use by the run"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(second.folder)) << "nothing is begun";
  EXPECT_EQ(rig.end().at("table").rate, 0.0);
  first.end();
}

}  // namespace
}  // namespace tumble
