#include "tumble/formats/unfinished.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tumble/formats/temporary_folder.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

void make_old(const fs::path& path) {
  const timespec long_ago[] = {{1'000'000'000, 0}, {1'000'000'000, 0}};
  ASSERT_EQ(utimensat(AT_FDCWD, path.c_str(), long_ago, 0), 0);
}

TEST(Unfinished, OnlyWhatIsOldAndHasNoOwnerIsSwept) {
  const ScratchFolder scratch;
  const fs::path folder = scratch.file("room");
  fs::create_directories(folder / "work-old");
  std::ofstream(folder / "work-old" / "copy") << "x";
  for (const char* name : {"work-owned", "work-young", "other"}) std::ofstream(folder / name) << "x";
  const int owned = open((folder / "work-owned").c_str(), O_RDONLY);
  lock_unfinished(owned);
  for (const char* name : {"work-old", "work-owned", "other"}) make_old(folder / name);
  sweep_unfinished(folder, "work-", "");
  EXPECT_FALSE(fs::exists(folder / "work-old"));
  EXPECT_TRUE(fs::exists(folder / "work-owned"));
  EXPECT_TRUE(fs::exists(folder / "work-young"));
  EXPECT_TRUE(fs::exists(folder / "other"));
  close(owned);
}

TEST(Unfinished, AFolderForTemporaryFilesIsLocked) {
  const TemporaryFolder mine;
  make_old(mine.path());
  const fs::path room = mine.path().parent_path() / "";  // the same folder by another name: it is looked at again
  sweep_unfinished(room, mine.path().filename().string(), "");
  EXPECT_TRUE(fs::exists(mine.path()));
}

}  // namespace
}  // namespace tumble
