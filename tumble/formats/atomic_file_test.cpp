#include "tumble/formats/atomic_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

struct AtomicFileTest : testing::Test {
  fs::path folder = fs::temp_directory_path() / ("tumble_atomic_" + std::to_string(getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  std::string in(const char* name) const { return (folder / name).string(); }
};

TEST_F(AtomicFileTest, WritesAndReplaces) {
  write_file_atomically(in("a.json"), "one");
  write_file_atomically(in("a.json"), "two");
  EXPECT_EQ(read_text_file(in("a.json")), "two");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(AtomicFileTest, LeavesTheOldFileUntilCommit) {
  write_file_atomically(in("a"), "old");
  {
    AtomicFile file(in("a"));
    file.write("new");
    EXPECT_EQ(read_text_file(in("a")), "old");
  }
  EXPECT_EQ(read_text_file(in("a")), "old");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(AtomicFileTest, FollowsLinksAndKeepsPermissions) {
  write_file_atomically(in("real"), "old");
  chmod(in("real").c_str(), 0640);
  fs::create_symlink("real", folder / "link");
  write_file_atomically(in("link"), "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_text_file(in("real")), "new");
  EXPECT_EQ(fs::status(folder / "real").permissions(), static_cast<fs::perms>(0640));
}

TEST_F(AtomicFileTest, FollowsALinkToAFileThatIsNotThereYet) {
  fs::create_directory(folder / "there");
  fs::create_symlink("there/second", folder / "first");
  fs::create_symlink("file", folder / "there" / "second");
  write_file_atomically(in("first"), "new");
  EXPECT_TRUE(fs::is_symlink(folder / "first"));
  EXPECT_EQ(read_text_file(in("there/file")), "new");
  fs::create_symlink("round", folder / "round");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {in("round/x")}, .pattern = "cannot write"},
                      [&] { write_file_atomically(in("round/x"), "new"); }));
}

TEST_F(AtomicFileTest, WritesToDevicesDirectly) {
  write_file_atomically("/dev/null", "nothing");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(AtomicFileTest, SaysWhatCannotBeWritten) {
  for (const auto& path : {in("no/such/folder/a"), folder.string()}) {
    try {
      write_file_atomically(path, "x");
      FAIL() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind, Error::Kind::bad_file);
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    }
  }
}

// A limit on the file size fails writes as a full disk does, and needs no privilege.
TEST_F(AtomicFileTest, FullDiskLeavesNothingBehind) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  write_file_atomically(in("fits"), std::string(4096, 'x'));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {in("large")}, .part = "File too large"},
                      [&] { write_file_atomically(in("large"), std::string(100000, 'x')); }));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(entries(), 1u);
}

TEST_F(AtomicFileTest, AnInterruptedProgramLeavesOnlyWhatWasCommitted) {
  write_file_atomically(in("whole"), "x");
  AtomicFile first(in("a")), moved(in("b"));
  const AtomicFile second(std::move(moved));
  EXPECT_EQ(entries(), 3u);
  unlink_unfinished();
  EXPECT_EQ(entries(), 1u);
}

TEST_F(AtomicFileTest, MissingFileIsSaid) {
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {in("none")}, .pattern = "cannot read"},
                      [&] { read_text_file(in("none")); }));
}

}  // namespace
}  // namespace tumble
