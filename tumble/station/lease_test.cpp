#include "tumble/station/lease.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

Station station_at(const std::string& link) {
  Station station;
  StationDevice device;
  device.name = "table";
  device.link = link;
  station.devices.push_back(device);
  return station;
}

/// A link that no other test has.
std::string own_link(const char* name) {
  return "tcp:lease." + std::string(name) + ":" + std::to_string(getpid() % 60000 + 1);
}

TEST(Lease, ASecondRunIsRefusedAndTheFirstIsNamed) {
  const Station station = station_at(own_link("second"));
  Lease first(station, "first-run");
  try {
    const Lease second(station, "second-run");
    FAIL() << "two runs on one rig";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("first-run"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(std::ranges::any_of(runs_going_on(), [](const auto& run) { return run.run.ends_with("first-run"); }));
  first.end();
}

TEST(Lease, ARunThatEndsLeavesNothingBehind) {
  const Station station = station_at(own_link("ends"));
  {
    Lease lease(station, "one");
    lease.end();
  }
  Lease next(station, "next");
  EXPECT_TRUE(next.left_behind().empty());
  next.end();
}

TEST(Lease, AProcessThatIsKilledLeavesItsRunBehind) {
  const Station station = station_at(own_link("killed"));
  const pid_t child = fork();
  if (child == 0) {
    const Lease lease(station, "killed-run");
    _exit(0);  // without end()
  }
  ASSERT_GT(child, 0);
  int status = 0;
  waitpid(child, &status, 0);
  Lease next(station, "next");
  ASSERT_EQ(next.left_behind().size(), 1u);
  EXPECT_EQ(next.left_behind()[0].process, child);
  EXPECT_TRUE(next.left_behind()[0].run.ends_with("killed-run"));
  next.end();
}

}  // namespace
}  // namespace tumble
