#include "tumble/recorder/disk.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/testing/faulty_disk.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::DiskFault;
using testing::FaultyDisk;

void put_disk_text(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

TEST(Disk, RefusesEverythingAfterAFailedSynchronisation) {
  const ScratchFolder folder;
  const std::string path = folder.file("a");
  put_disk_text(path, "abc");
  FaultyDisk faulty({DiskFault::Kind::fails, 2, 0});
  Disk& disk = faulty.disk();
  EXPECT_NO_THROW(disk.synchronise(path));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {path}, .pattern = "synchronise"},
                      [&] { disk.synchronise(path); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {path}, .pattern = "synchronise"}, [&] {
    disk.synchronise(path);
  })) << "a second one would succeed, and the data would not be there";
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {path}, .pattern = "rename"},
                      [&] { disk.rename(path, folder.file("b")); }));
  EXPECT_TRUE(disk.failed());
}

TEST(Disk, APowerCutTakesBackANameWhoseFolderWasNotSynchronised) {
  int kept = 0, lost = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const ScratchFolder folder;
    FaultyDisk faulty({DiskFault::Kind::crash, 4, seed});
    Disk& disk = faulty.disk();
    disk.produce(folder.file("part"), [&] { put_disk_text(folder.file("part"), "whole"); });
    disk.synchronise(folder.file("part"));
    disk.rename(folder.file("part"), folder.file("name"));
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.path}, .pattern = "synchronise"},
                        [&] { disk.synchronise_folder(folder.path); }));
    faulty.power_cut();
    const bool there = std::filesystem::exists(folder.file("name"));
    (there ? kept : lost) += 1;
    if (there) {
      EXPECT_EQ(read_text_file(folder.file("name")), "whole") << "its content was synchronised";
    }
  }
  EXPECT_GT(kept, 0);
  EXPECT_GT(lost, 0);
}

TEST(Disk, APowerCutKeepsAFolderThatWasSynchronised) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const ScratchFolder folder;
    FaultyDisk faulty({DiskFault::Kind::crash, 5, seed});
    Disk& disk = faulty.disk();
    disk.produce(folder.file("part"), [&] { put_disk_text(folder.file("part"), "whole"); });
    disk.synchronise(folder.file("part"));
    disk.rename(folder.file("part"), folder.file("name"));
    disk.synchronise_folder(folder.path);
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("name")}, .pattern = "remove"},
                        [&] { disk.remove(folder.file("name")); }));
    faulty.power_cut();
    EXPECT_FALSE(std::filesystem::exists(folder.file("part")));
    if (std::filesystem::exists(folder.file("name"))) {
      EXPECT_EQ(read_text_file(folder.file("name")), "whole");
    }
  }
}

TEST(Disk, AFullDiskHasRoomAgainForWhatIsRemoved) {
  const ScratchFolder folder;
  FaultyDisk faulty({DiskFault::Kind::full, 2, 0});
  Disk& disk = faulty.disk();
  disk.allocate(folder.file("reserve"), 1000);
  EXPECT_EQ(std::filesystem::file_size(folder.file("reserve")), 1000u);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("more")}, .part = "No space left"},
                      [&] { disk.allocate(folder.file("more"), 10); }));
  EXPECT_FALSE(disk.failed()) << "nothing was written, and room can be made";
  EXPECT_NO_THROW(disk.remove(folder.file("reserve")));
}

}  // namespace
}  // namespace tumble
