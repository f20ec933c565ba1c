// What survives: a power cut, a full disk and a failed synchronisation at each call to the disk, and the sudden end of
// the process.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <random>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/recorder.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/recorder/testing/faulty_disk.hpp"
#include "tumble/recorder/testing/small_run.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using testing::DiskFault;
using testing::FaultyDisk;

/// A small run with a checkpoint every few commits.
struct SmallRun {
  GivenItems items;  ///< that the recorder accepted
  Acknowledged acknowledged;
  std::optional<StoreFailure> failure;
  std::uint64_t acknowledged_at_failure = 0;
  int reports = 0;
  bool opened = false;
  std::uint64_t calls = 0;
};

SmallRun small_run(const std::string& folder, FaultyDisk& disk) {
  SmallRun run;
  RecorderOptions options;
  options.background = false;
  options.reserve_bytes = 1 << 16;
  options.checkpoint_bytes = 20000;
  options.on_commit = [&](const Acknowledged& acknowledged) { run.acknowledged = acknowledged; };
  options.on_failure = [&](const StoreFailure&) {
    ++run.reports;
    run.acknowledged_at_failure = run.acknowledged.sequence;
  };
  try {
    Recorder recorder(folder, disk, options);
    run.opened = true;
    begin_run(recorder);
    for (int k = 0; k < 120; ++k) {
      add_step(recorder, k, run.items);
      if (k % 5 == 4) recorder.flush();
    }
    run.failure = recorder.failure();
    recorder.close(1.2, "complete");
    if (!run.failure) run.failure = recorder.failure();
  } catch (const Error&) {
  }
  run.calls = disk.calls();
  return run;
}

/// Everything that was acknowledged is there with its bytes, and nothing else that was not given.
void expect_kept(const std::string& folder, const SmallRun& run, const std::string& what) {
  GivenItems stored;
  if (run.acknowledged.sequence > 0 || run.opened) {
    try {
      stored = items_of_store(folder);
    } catch (const Error& error) {
      ASSERT_EQ(run.acknowledged.sequence, 0u) << what << ": " << error.what();
    }
  }
  for (const auto& [sequence, item] : run.items) {
    if (sequence > run.acknowledged.sequence) break;
    ASSERT_TRUE(stored.contains(sequence))
        << what << ": item " << sequence << " of " << run.acknowledged.sequence << " acknowledged is lost";
    ASSERT_EQ(stored[sequence], item) << what << ": item " << sequence;
  }
  for (const auto& [sequence, item] : stored)
    if (const auto given = run.items.find(sequence); given != run.items.end())
      ASSERT_EQ(item, given->second) << what << ": item " << sequence;
    else
      ASSERT_EQ(item.kind, StoreItem::Kind::event) << what << ": item " << sequence << " was never given";
}

std::uint64_t calls_of_a_small_run() {
  const ScratchFolder folder;
  FaultyDisk disk;
  const SmallRun run = small_run(folder.path, disk);
  EXPECT_FALSE(run.failure);
  return run.calls;
}

TEST(RecorderCrash, APowerCutAtAnyCallLosesNothingThatWasAcknowledged) {
  const std::uint64_t calls = calls_of_a_small_run();
  ASSERT_GT(calls, 100u);
  std::uint64_t acknowledged = 0;
  for (std::uint64_t at = 1; at <= calls; ++at)
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      const ScratchFolder folder;
      SmallRun run;
      {
        FaultyDisk disk({DiskFault::Kind::crash, at, 1000 * seed + at});
        run = small_run(folder.path, disk);
        disk.power_cut();
      }
      acknowledged += run.acknowledged.sequence;
      expect_kept(folder.path, run, "power cut at call " + std::to_string(at) + ", seed " + std::to_string(seed));
      if (HasFatalFailure()) return;
    }
  EXPECT_GT(acknowledged, 0u);
}

TEST(RecorderCrash, AFailedCallIsReportedOnceAndKeepsWhatWasAcknowledged) {
  const std::uint64_t calls = calls_of_a_small_run();
  for (std::uint64_t at = 1; at <= calls; ++at) {
    const ScratchFolder folder;
    const std::string what = "failure of call " + std::to_string(at);
    SmallRun run;
    {
      FaultyDisk disk({DiskFault::Kind::fails, at, 0});
      run = small_run(folder.path, disk);
    }
    if (run.failure) {
      EXPECT_EQ(run.failure->kind, StoreFailure::Kind::disk) << what;
      EXPECT_EQ(run.reports, 1) << what;
      EXPECT_EQ(run.acknowledged.sequence, run.acknowledged_at_failure)
          << what << ": after a failure nothing more is acknowledged";
    }
    // Only the making of the store, and the tidying up after the last commit, go without a report.
    if (!run.failure && run.opened) {
      EXPECT_GE(run.acknowledged.sequence, run.items.rbegin()->first) << what;
    }
    expect_kept(folder.path, run, what);
    if (HasFatalFailure()) return;
  }
}

TEST(RecorderCrash, AFullDiskIsReportedOnceAndKeepsWhatWasAcknowledged) {
  const std::uint64_t calls = calls_of_a_small_run();
  int ended = 0;
  for (std::uint64_t at = 1; at <= calls; ++at) {
    const ScratchFolder folder;
    const std::string what = "full at call " + std::to_string(at);
    SmallRun run;
    {
      FaultyDisk disk({DiskFault::Kind::full, at, 0});
      run = small_run(folder.path, disk);
    }
    expect_kept(folder.path, run, what);
    if (HasFatalFailure()) return;
    if (!run.failure && run.opened) {
      EXPECT_GE(run.acknowledged.sequence, run.items.rbegin()->first) << what << ": there was room for everything";
    }
    if (!run.failure) continue;
    EXPECT_EQ(run.failure->kind, StoreFailure::Kind::full) << what;
    EXPECT_EQ(run.reports, 1) << what;
    const auto stored = items_of_store(folder.path);
    const std::string& last = stored.rbegin()->second.bytes;
    EXPECT_NE(last.find("is full"), std::string::npos) << what << ": the reserve has room for the end record";
    EXPECT_EQ(run.acknowledged.sequence, stored.rbegin()->first) << what;
    ++ended;
  }
  EXPECT_GT(ended, 20);
}

/// The child: records for ever, and writes to the pipe what has been acknowledged.
[[noreturn]] void record_until_killed(const std::string& folder, int pipe) {
  Disk disk;
  RecorderOptions options;
  options.commit_after = 0.003;
  options.reserve_bytes = 0;
  options.checkpoint_bytes = 200000;
  options.on_commit = [&](const Acknowledged& acknowledged) {
    if (write(pipe, &acknowledged.sequence, sizeof acknowledged.sequence) < 0) _exit(1);
  };
  Recorder recorder(folder, disk, options);
  begin_run(recorder);
  GivenItems unused;
  for (int k = 0;; ++k) {
    add_step(recorder, k, unused);
    if (k % 50 == 0) usleep(500);
  }
}

/// Kills a recording child after so many microseconds. Returns the last sequence number that it had acknowledged.
std::uint64_t acknowledged_until_killed(const std::string& folder, useconds_t after) {
  int ends[2];
  if (pipe(ends) != 0) return 0;
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    record_until_killed(folder, ends[1]);
  }
  close(ends[1]);
  std::uint64_t last = 0, next = 0;
  const bool began = read(ends[0], &last, sizeof last) == sizeof last;
  EXPECT_TRUE(began);
  usleep(after);
  kill(child, SIGKILL);
  while (read(ends[0], &next, sizeof next) == sizeof next) last = next;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return last;
}

TEST(RecorderCrash, AKilledProcessLosesNothingThatWasAcknowledged) {
  const char* const wanted = std::getenv("TUMBLE_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 10;
  std::mt19937_64 random(20);
  GivenItems all;  // what the child gives, step by step
  {
    const ScratchFolder folder;
    Disk disk;
    RecorderOptions options;
    options.reserve_bytes = 0;
    options.background = false;
    Recorder recorder(folder.path, disk, options);
    begin_run(recorder);
    for (int k = 0; k < 30000; ++k) add_step(recorder, k, all);
  }
  for (int i = 0; i < kills; ++i) {
    const ScratchFolder folder;
    const std::uint64_t last = acknowledged_until_killed(folder.path, static_cast<useconds_t>(random() % 150'000));
    const GivenItems stored = items_of_store(folder.path);
    ASSERT_GE(stored.size(), last) << "kill " << i;
    ASSERT_EQ(stored.rbegin()->first, stored.size()) << "kill " << i;
    for (const auto& [sequence, item] : stored) {
      if (sequence > all.rbegin()->first) break;
      ASSERT_EQ(item, all[sequence]) << "kill " << i << ", item " << sequence;
    }
  }
}

}  // namespace
}  // namespace tumble
