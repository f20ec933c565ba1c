#include "tumble/serve/jobs/folder_below.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble::jobs {
namespace {

namespace fs = std::filesystem;

/// A file system gives the number of a folder that was removed to the next one.
TEST(FolderBelow, AnotherFolderOfTheSameNameHasAnotherNumber) {
  const ScratchFolder scratch;
  const auto root = scratch.path.string();
  ASSERT_TRUE(make_folder_below(root, "jobs", "000001"));
  const auto number = number_of(folder_below(root, {"jobs", "000001"}));
  EXPECT_NE(number, 0u);
  EXPECT_EQ(number_of(folder_below(root, {"jobs", "000001"})), number);
  fs::rename(scratch.path / "jobs", scratch.path / "moved");
  EXPECT_EQ(number_of(folder_below(root, {"moved", "000001"})), number);
  struct statx status {};
  const auto folder = folder_below(root, {"moved", "000001"});
  if (statx(folder.number(), "", AT_EMPTY_PATH, STATX_BTIME, &status) != 0 || (status.stx_mask & STATX_BTIME) == 0)
    GTEST_SKIP() << "this file system keeps no times of birth";
  fs::rename(scratch.path / "moved", scratch.path / "jobs");
  for (int again = 0; again < 20; ++again) {
    fs::remove_all(scratch.path / "jobs");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the clock of the file system has ticks
    ASSERT_TRUE(make_folder_below(root, "jobs", "000001"));
    EXPECT_NE(number_of(folder_below(root, {"jobs", "000001"})), number);
  }
}

}  // namespace
}  // namespace tumble::jobs
