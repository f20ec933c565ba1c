// Plans carried out over real TCP links against a virtual rig that is served at them.
#include "tumble/desk/run_plan.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>

#include "tumble/recorder/recorder_read.hpp"
#include "tumble/recorder/testing/small_run.hpp"
#include "tumble/rehearsal/testing/served_rig.hpp"
#include "tumble/station/lease.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::run_plan_test {
namespace {

using testing::run_over_tcp;
using testing::station_over_tcp;

constexpr double standing = 0.01 * degree;  ///< [rad/s] what counts as a rate of zero
constexpr double fast = 20.0;               ///< [1] of the clock of the rig

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
  Station station = station_over_tcp(plan, scratch);
  station.equipment = {{"table", "RT-1", "C-1", "2020-01-01"}};
  ServedRig rig(plan, station, fast);
  auto run = run_over_tcp(plan, station, scratch.file("run"), fast);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "table RT-1", .pattern = "--accept-expired"}, [&] {
    run_plan(run);
  })) << "its calibration has expired";
  run.accept_expired = "the laboratory is closed";
  const RunEnd end = run_plan(run);
  EXPECT_EQ(end.ending, RunEnding::complete) << end.text.text();
  EXPECT_LE(std::abs(rig.end().at("table").rate), standing);
  Disk disk;
  const auto sealed = seal(scratch.file("run"), disk);
  ASSERT_EQ(sealed.size(), 1u);
  const Recording recording = read_recording(sealed[0].path, {}, {});
  EXPECT_EQ(recording.marks.size(), 2u);
  const auto accepted = std::ranges::find(recording.findings, "equipment_expired", &Finding::code);
  ASSERT_NE(accepted, recording.findings.end()) << "a result from this file says so";
  EXPECT_NE(accepted->message.find("table RT-1: its calibration C-1 was due on 2020-01-01 (the laboratory is closed)"),
            std::string::npos)
      << accepted->message;
}

/// Pseudo-terminals in place of serial lines.
TEST(RunPlan, APlanIsCarriedOutOverSerialLines) {
  const ScratchFolder scratch;
  const Plan plan = short_plan();
  Station station = station_over_tcp(plan, scratch);
  for (StationDevice& device : station.devices) device.link = "serial:/dev/ttyS0:115200";
  for (StationInstrument& instrument : station.instruments) instrument.link = "serial:/dev/ttyS0:921600";
  ServedRig rig(plan, station, fast);
  const std::size_t devices = station.devices.size();
  for (std::size_t d = 0; d < devices; ++d) station.devices[d].link = rig.addresses()[d] + ":115200";
  station.instruments[0].link = rig.addresses()[devices] + ":921600";
  const RunEnd end = run_plan(run_over_tcp(plan, station, scratch.file("run"), fast));
  EXPECT_EQ(end.ending, RunEnding::complete) << end.text.text();
  EXPECT_LE(std::abs(rig.end().at("table").rate), standing);
  Disk disk;
  const auto sealed = seal(scratch.file("run"), disk);
  EXPECT_EQ(read_recording(sealed.at(0).path, {}, {}).marks.size(), 2u);
}

TEST(RunPlan, ASecondRunOnTheSameRigIsRefusedBeforeAnythingMoves) {
  const ScratchFolder scratch;
  const Plan plan = short_plan();
  const Station station = station_over_tcp(plan, scratch);
  ServedRig rig(plan, station, fast);
  Lease first(station, scratch.file("first"));
  auto second = run_over_tcp(plan, station, scratch.file("second"), fast);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = scratch.file("first"), .pattern = "is in use by the run"},
                      [&] { run_plan(second); }));
  EXPECT_FALSE(std::filesystem::exists(second.folder)) << "nothing is begun";
  EXPECT_LE(std::abs(rig.end().at("table").rate), standing);
  first.end();
}

TEST(RunPlan, ARunThatIsRefusedLeavesNothingToBeTakenOver) {
  const ScratchFolder scratch;
  const Plan plan = short_plan();
  const Station station = station_over_tcp(plan, scratch);
  ServedRig rig(plan, station, fast);
  const auto run = run_over_tcp(plan, station, scratch.file("run"), fast);
  std::filesystem::create_directory(run.folder);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {run.folder}, .pattern = "is there already"}, [&] {
    run_plan(run);
  })) << "its folder is there already";
  EXPECT_TRUE(Lease(station, scratch.file("other")).left_behind().empty());
}

/// Files of this process may have so many bytes, while it lives.
struct FileLimit {
  rlimit before{};
  void (*handler)(int) = std::signal(SIGXFSZ, SIG_IGN);

  explicit FileLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit limit{bytes, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
  }
};

/// A disk without room, as a limit of the size of files.
TEST(RunPlan, WithoutRoomIsNotBegunAndSaysWhichFileHasNone) {
  const ScratchFolder scratch;
  Plan plan = short_plan();
  plan.text = std::string(5000, '#');
  const Station station = station_over_tcp(plan, scratch);
  ServedRig rig(plan, station, fast);
  const auto run = run_over_tcp(plan, station, scratch.file("run"), fast);
  const auto refusal = [&](rlim_t bytes) {
    const FileLimit limit(bytes);
    return refusal_of([&] { run_plan(run); });
  };
  EXPECT_TRUE(refuses(Error::Kind::bad_file,
                      Asked{.values = {run.folder + "/plan.toml"}, .part = "File too large", .pattern = "cannot write"},
                      refusal(1000)));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_file,
              Asked{.values = {"67108864", run.folder + "/" + std::string(reserve_name)}, .part = "File too large"},
              refusal(1'000'000)));
  EXPECT_FALSE(std::filesystem::exists(run.folder)) << "it would be taken for a run";
  EXPECT_TRUE(Lease(station, scratch.file("other")).left_behind().empty());
  EXPECT_EQ(run_plan(run).ending, RunEnding::complete) << "as soon as there is room";
  {
    const FileLimit limit(10'000);
    Disk disk;
    const std::string file = run.folder + "/recording.h5";
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {file, file + ".part"}, .pattern = "cannot write"},
                        [&] { seal(run.folder, disk); }));
  }
  Disk disk;
  EXPECT_EQ(seal(run.folder, disk).size(), 1u);
}

/// A run in a process of its own, which begins when the rig is served.
struct RunningProcess {
  pid_t process = -1;
  int begin = -1;  ///< end of a pipe: a byte lets it begin

  explicit RunningProcess(const PlannedRunAtStation& run) {
    int ends[2];
    if (pipe(ends) != 0) return;
    process = fork();
    if (process != 0) {
      close(ends[0]);
      begin = ends[1];
      return;
    }
    char byte = 0;
    if (read(ends[0], &byte, 1) != 1) _exit(100);
    std::signal(SIGTERM, [](int) { stop_wanted = 1; });
    _exit(carry(run));
  }
  void start() const { EXPECT_EQ(write(begin, "x", 1), 1); }
  /// Status of its exit, or -1 for one that was killed.
  int wait() const {
    int status = 0;
    waitpid(process, &status, 0);
    close(begin);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  static inline volatile std::sig_atomic_t stop_wanted = 0;

  static int carry(PlannedRunAtStation run) try {
    run.company.orders = [inner = run.company.orders, told = false]() mutable {
      auto orders = inner();
      if (stop_wanted && !std::exchange(told, true)) orders.push_back(RunOrder{RunOrder::Kind::stop, "SIGTERM"});
      return orders;
    };
    return static_cast<int>(run_plan(run).ending);
  } catch (const std::exception&) {
    return 99;
  }
};

/// Three segments of 40 s of the rig: 2 s of the wall each.
Plan longer_plan() {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  plan.schedule.resize(3);
  for (Segment& segment : plan.schedule) segment.duration = 40.0;
  return plan;
}

TEST(RunPlan, ATerminatedProcessEndsByTheSafeList) {
  const ScratchFolder scratch;
  const Plan plan = longer_plan();
  const Station station = station_over_tcp(plan, scratch);
  const RunningProcess process(run_over_tcp(plan, station, scratch.file("run"), fast));
  ServedRig rig(plan, station, fast);
  process.start();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  ASSERT_EQ(kill(process.process, SIGTERM), 0);
  EXPECT_EQ(process.wait(), static_cast<int>(RunEnding::stopped));
  EXPECT_LE(std::abs(rig.end().at("table").rate), standing);
  const auto rows = journal_of(scratch.file("run"));
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows.back().kind, RunRow::Kind::run_ends);
  EXPECT_EQ(rows.back().ending, RunRow::Ending::stopped);
}

TEST(RunPlan, AKilledProcessLeavesARunThatIsTakenOverAndCarriedOn) {
  const Plan plan = longer_plan();
  for (const int milliseconds : {900, 2600}) {
    const ScratchFolder scratch;
    const Station station = station_over_tcp(plan, scratch);
    auto run = run_over_tcp(plan, station, scratch.file("run"), fast, 120.0);
    const RunningProcess process(run);
    ServedRig rig(plan, station, fast);
    process.start();
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ASSERT_EQ(kill(process.process, SIGKILL), 0);
    EXPECT_EQ(process.wait(), -1);
    const GivenItems before = items_of_store(run.folder);
    run.resume = true;
    std::filesystem::create_directory(run.folder + "/takeover");  // it was taken over before, and killed again
    const RunEnd end = run_plan(run);
    EXPECT_EQ(end.ending, RunEnding::complete) << end.text.text();
    EXPECT_TRUE(std::filesystem::exists(run.folder + "/takeover-2")) << "the safe list comes first";
    EXPECT_LE(std::abs(rig.end().at("table").rate), standing);
    const GivenItems after = items_of_store(run.folder);
    for (const auto& [sequence, item] : before)
      ASSERT_TRUE(after.contains(sequence) && after.at(sequence) == item) << "item " << sequence;
    Disk disk;
    const auto sealed = seal(run.folder, disk);
    EXPECT_EQ(read_recording(sealed.at(0).path, {}, {}).marks.size(), plan.schedule.size());
  }
}

}  // namespace
}  // namespace tumble::run_plan_test
