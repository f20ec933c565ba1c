#include "tumble/station/lease.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

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

/// A link that no other test has. Ports below 32768 are given to nobody by the kernel.
std::string own_link(int test, const std::string& host = "127.0.0.1") {
  return "tcp:" + host + ":" + std::to_string(1024 + (getpid() % 3000) * 10 + test);
}

Refused lease_refusal(const Station& station, const std::string& run) {
  return tumble::refusal_of([&] { const Lease lease(station, run); });
}

/// Whether the device is refused since that run has it.
::testing::AssertionResult is_taken_by(const std::string& run, const Refused& refusal) {
  return refuses(Error::Kind::bad_file, Asked{.part = run, .pattern = "is in use by the run"}, refusal);
}

/// The files that say who has a lease.
std::vector<std::filesystem::path> files_of_run(const std::string& run) {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"/run/lock/tumble-leases", "/var/tmp/tumble-leases"}) {
    std::error_code problem;
    for (const auto& entry : std::filesystem::directory_iterator(folder, problem)) {
      std::ifstream file(entry.path());
      if (std::string((std::istreambuf_iterator<char>(file)), {}).find(run + "\n") != std::string::npos)
        files.push_back(entry.path());
    }
  }
  return files;
}

TEST(Lease, ASecondRunIsRefusedAndTheFirstIsNamed) {
  const Station station = station_at(own_link(0));
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
  const Station station = station_at(own_link(1));
  {
    Lease lease(station, "one");
    lease.end();
  }
  Lease next(station, "next");
  EXPECT_TRUE(next.left_behind().empty());
  next.end();
}

TEST(Lease, AProcessThatIsKilledLeavesItsRunBehind) {
  const Station station = station_at(own_link(2));
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

TEST(Lease, ADeviceIsTheSameByAnyNameOfItsLink) {
  Lease first(station_at(own_link(3)), "by-number");
  for (const char* host : {"localhost", "127.1", "2130706433", "0x7f.1", "[::ffff:127.0.0.1]", "0.0.0.0"})
    EXPECT_TRUE(is_taken_by("by-number", lease_refusal(station_at(own_link(3, host)), "again"))) << host;
  EXPECT_TRUE(lease_refusal(station_at(own_link(4)), "beside").empty()) << "another port is another device";
  EXPECT_TRUE(lease_refusal(station_at(own_link(3, "127.0.0.2")), "beside").empty()) << "and so is another address";
  first.end();
}

TEST(Lease, ADeviceIsTheSameAtAnyAddressWhereItsSerialNumberIsExpected) {
  const std::string serial = "SN " + std::to_string(getpid());
  const auto station = [&](const std::string& host, const std::string& identity, const std::string& controller) {
    Station one = station_at("tcp:" + host + ":9878");
    one.devices[0].identity = identity;
    one.devices[0].controller = controller;
    return one;
  };
  Lease first(station("192.0.2.1", serial, "acutrol_like"), "by-network");
  EXPECT_TRUE(is_taken_by(
      "by-network", lease_refusal(station("192.0.2.2", "s/n: " + std::to_string(getpid()), "acutrol_like"), "again")));
  const auto is_free = [](const Station& one) { return lease_refusal(one, "beside").empty(); };
  EXPECT_TRUE(is_free(station("192.0.2.2", serial + "1", "acutrol_like")));
  EXPECT_TRUE(is_free(station("192.0.2.2", serial, "grbl"))) << "of another maker";
  EXPECT_TRUE(is_free(station("192.0.2.2", "ACUTROL 3000", "acutrol_like"))) << "a type is no number";
  EXPECT_TRUE(is_free(station("127.0.0.1", serial, "acutrol_like"))) << "played on this computer";
  first.end();
}

TEST(Lease, ASerialDeviceIsTheSameByAnyOfItsPaths) {
  const ScratchFolder scratch;
  const int line = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(line >= 0 && grantpt(line) == 0 && unlockpt(line) == 0);
  const std::string device = ptsname(line);
  std::filesystem::create_symlink(device, scratch.file("by-id"));
  Lease first(station_at("serial:" + device), "by-device");
  EXPECT_TRUE(
      is_taken_by("by-device", lease_refusal(station_at("serial:" + scratch.file("by-id") + ":9600"), "again")));
  first.end();
  close(line);
}

TEST(Lease, NeitherAnotherTmpdirNorACleanerLetsASecondRunIn) {
  const ScratchFolder scratch;
  const Station station = station_at(own_link(5));
  Lease first(station, "cleaned-run");
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before == nullptr ? "" : before;
  setenv("TMPDIR", scratch.path.c_str(), 1);
  EXPECT_TRUE(is_taken_by("cleaned-run", lease_refusal(station, "again")));
  before == nullptr ? unsetenv("TMPDIR") : setenv("TMPDIR", kept.c_str(), 1);
  const auto files = files_of_run("cleaned-run");
  EXPECT_FALSE(files.empty());
  for (const auto& file : files) std::filesystem::remove(file);
  EXPECT_TRUE(is_taken_by("", lease_refusal(station, "again"))) << "nobody knows its name any more";
  const auto all = runs_going_on();
  EXPECT_TRUE(std::ranges::any_of(all, [](const auto& run) { return run.process == getpid(); }));
  first.end();
}

/// `tumble stop` sends a signal to the process: another user could name any.
TEST(Lease, WhoHasItIsWhatTheKernelSays) {
  const Station station = station_at(own_link(6));
  int ready[2], over[2];
  ASSERT_TRUE(pipe(ready) == 0 && pipe(over) == 0);
  const pid_t child = fork();
  if (child == 0) {
    Lease lease(station, "true-run");
    char byte = 1;
    const bool told = write(ready[1], &byte, 1) == 1;
    close(over[1]);
    if (told && read(over[0], &byte, 1) >= 0) lease.end();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  for (const auto& file : files_of_run("true-run"))
    std::ofstream(file) << getpid() << ' ' << std::filesystem::absolute("true-run").string() << "\n";
  const auto all = runs_going_on();
  EXPECT_TRUE(std::ranges::any_of(all, [&](const auto& run) { return run.process == child; }));
  close(over[0]);
  close(over[1]);
  int status = 0;
  waitpid(child, &status, 0);
  for (const int end : ready) close(end);
  Lease next(station, "next");
  next.end();
}

}  // namespace
}  // namespace tumble
