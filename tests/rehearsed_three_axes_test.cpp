// A controller whose lines carry three axes at once drives a table: the axis that is told something moves, and the
// others go on as they were told before.

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

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

TEST(RehearsedThreeAxes, EachDoesWhatThePlanSays) {
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/imu_turntable_short.toml", {});
  // outer and inner turn; all stand; outer and middle turn; all stand
  rehearsal.plan.schedule.resize(5);
  for (Segment& segment : rehearsal.plan.schedule) segment.duration = 10.0;
  rehearsal.station = at_one_controller(rehearsal.plan);
  rehearsal.station->file = scratch.file("station.toml");
  std::ofstream(scratch.file("frames.toml")) << frames_for(rehearsal.plan);
  rehearsal.folder = scratch.file("run");
  std::string notes;
  rehearsal.company.note = [&](const Note& note, double) {
    notes += std::string(name(note.kind)) + ": " + note.text.text() + "\n";
  };
  const Rehearsed rehearsed = rehearse(rehearsal);
  ASSERT_EQ(rehearsed.end.ending, RunEnding::complete) << notes.substr(0, 2000);
  std::vector<RunRow> ends;
  for (const RunRow& row : journal_of(rehearsal.folder))
    if (row.kind == RunRow::Kind::segment_ends) ends.push_back(row);
  ASSERT_EQ(ends.size(), 5u) << "each segment at its first attempt";
  for (const RunRow& row : ends) {
    EXPECT_EQ(row.ending, RunRow::Ending::complete) << row.label;
    ASSERT_EQ(row.achieved.size(), 3u) << row.label;
    for (const auto& [channel, demanded] : row.demanded)
      EXPECT_NEAR(row.achieved.at(channel), demanded, 0.01 * degree) << row.label << ", " << channel;
  }
  EXPECT_NEAR(ends[1].achieved.at("inner.rate"), -60.0 * degree, 0.01 * degree);
  EXPECT_NEAR(ends[3].achieved.at("outer.rate"), -200.0 * degree, 0.01 * degree);
  EXPECT_NEAR(ends[3].achieved.at("middle.rate"), -60.0 * degree, 0.01 * degree);
}

}  // namespace
}  // namespace tumble
