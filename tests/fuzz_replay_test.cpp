// Bytes that once crashed a reader, or were read as what they are not: tests/reference/fuzz/<target>/. script/fuzz
// finds them.
#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/targets.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

TEST(FuzzReplay, FormerCrashesAreReadOrRefused) {
  const ScratchFolder folder;
  const std::filesystem::path root(TUMBLE_SOURCE_DIR "/tests/reference/fuzz");
  std::size_t replayed = 0;
  for (const auto& target : fuzz::target_names()) {
    if (!std::filesystem::exists(root / target)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(root / target)) {
      EXPECT_EQ(fuzz::run_target(target, read_text_file(entry.path().string()), folder.file("f")), "") << entry.path();
      ++replayed;
    }
  }
  EXPECT_GT(replayed, 0u);
}

TEST(FuzzReplay, SeedsOfEveryTargetAreSound) {
  const ScratchFolder folder;
  for (const auto& target : fuzz::target_names())
    for (const auto& seed : fuzz::seeds_of(target, TUMBLE_SOURCE_DIR, folder.file("seed")))
      EXPECT_EQ(fuzz::run_target(target, seed, folder.file("f")), "") << target;
}

}  // namespace
}  // namespace tumble
