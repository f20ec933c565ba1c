// A controller whose lines carry three axes at once drives a table: the axis that is told something moves, and the others
// go on as they were told before.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/station/made_station.hpp"
#include "tumble/station/rehearse.hpp"
#include "tumble/station/virtual_stream.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {
namespace {

/// The station that is made for the plan, with its three axes at one controller.
Station at_one_controller(const Plan& plan) {
  Station station = station_for(plan);
  StationDevice table = station.devices.front();
  table.name = "table";
  table.controller = "mn_three_axis";
  table.timeout = 3.0;  // four lines, 100 ms apart
  table.lost_after = 10.0;
  station.devices = {table, station.devices.back()};
  for (std::size_t axis = 0; axis < station.axes.size(); ++axis) {
    station.axes[axis].device = 0;
    station.axes[axis].number = static_cast<int>(axis) + 1;
  }
  station.safe.resize(1);
  station.power.device = 1;
  station.instruments.front().frames = "frames.toml";
  return station;
}

TEST(RehearsedThreeAxes, AtOneControllerLeadToTheTruthOfThePlan) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/imu_turntable_short.toml", {});
  rehearsal.station = at_one_controller(rehearsal.plan);
  rehearsal.station->file = scratch.file("station.toml");
  std::ofstream(scratch.file("frames.toml")) << frames_for(rehearsal.plan);
  rehearsal.folder = scratch.file("run");
  rehearsal.recording = scratch.file("run.h5");
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text;
  const Estimate found = identify(rehearsal.plan, {rehearsal.recording}, std::size_t{1} << 30, {});
  std::size_t compared = 0;
  for (std::size_t p = 0; p < found.parameters.size(); ++p) {
    const std::string& name = found.parameters[p].name;
    if (!rehearsal.plan.truth.has(name)) continue;
    EXPECT_NEAR(found.parameters[p].value, rehearsal.plan.truth.number(name), 4.0 * std::sqrt(found.covariance(p, p)))
        << name;
    ++compared;
  }
  EXPECT_EQ(compared, 45u);
}

}  // namespace
}  // namespace tumble
