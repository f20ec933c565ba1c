#include "tumble/recorder/recorder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/live_store/front.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/recorder/testing/small_run.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

RecorderOptions small_options(bool background) {
  RecorderOptions options;
  options.reserve_bytes = 1 << 16;
  options.background = background;
  return options;
}

TEST(Recorder, HandsBackEveryItemInTheOrderInWhichItWasGiven) {
  for (const bool background : {false, true}) {
    const ScratchFolder folder;
    Disk disk;
    GivenItems items;
    {
      Recorder recorder(folder.path, disk, small_options(background));
      begin_run(recorder);
      for (int k = 0; k < 500; ++k) add_step(recorder, k, items);
      ASSERT_TRUE(recorder.close(5.0, "complete"));
    }
    auto stored = items_of_store(folder.path);
    EXPECT_EQ(stored.rbegin()->second.bytes, "complete");
    stored.erase(std::prev(stored.end()));
    EXPECT_EQ(stored, items);
    EXPECT_EQ(folder.entries(), 1u) << "the write-ahead log and the reserve are removed";
  }
}

TEST(Recorder, AcknowledgesWithinTheTimeThatWasAskedFor) {
  const ScratchFolder folder;
  Disk disk;
  auto options = small_options(true);
  options.commit_after = 0.05;
  Recorder recorder(folder.path, disk, options);
  begin_run(recorder);
  const std::uint64_t sequence = recorder.raw(0, StoreDirection::received, 1.5, "abc");
  for (int i = 0; i < 1000 && recorder.acknowledged().sequence < sequence; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(recorder.acknowledged().sequence, sequence);
  EXPECT_EQ(recorder.acknowledged().time, 1.5);
}

TEST(Recorder, CommitsNothingBetweenTheItemsOfAWhole) {
  const ScratchFolder folder;
  Disk disk;
  auto options = small_options(true);
  options.commit_after = 0.01;
  Recorder recorder(folder.path, disk, options);
  begin_run(recorder);
  recorder.flush();
  const std::uint64_t before = recorder.acknowledged().sequence;
  std::uint64_t last = 0;
  {
    const Recorder::Whole whole(recorder);
    recorder.raw(0, StoreDirection::received, 1.5, std::string(2 * options.commit_bytes, 'x'));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_EQ(recorder.acknowledged().sequence, before);
    last = recorder.raw(0, StoreDirection::received, 1.6, "abc");
  }
  EXPECT_TRUE(recorder.flush());
  EXPECT_EQ(recorder.acknowledged().sequence, last);
}

TEST(Recorder, CommitsAFullChunkAtOnce) {
  const ScratchFolder folder;
  Disk disk;
  auto options = small_options(true);
  options.commit_after = 1e6;  // never
  Recorder recorder(folder.path, disk, options);
  begin_run(recorder);
  const std::uint64_t sequence = recorder.raw(0, StoreDirection::received, 1.5, std::string(options.chunk_bytes, 'x'));
  for (int i = 0; i < 1000 && recorder.acknowledged().sequence < sequence; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(recorder.acknowledged().sequence, sequence);
}

TEST(Recorder, CollectsAsMuchAsWasAskedForBeforeACommit) {
  const std::string chunk(1000, 'x');
  live_store::Front front({}, {.chunk_bytes = chunk.size(), .commit_bytes = 3 * chunk.size()});
  for (int k = 0; k < 3; ++k) {
    EXPECT_FALSE(front.urgent());
    front.raw(0, StoreDirection::received, k, chunk);
  }
  EXPECT_TRUE(front.urgent());
  front.take();
  EXPECT_FALSE(front.urgent());
  front.event({.time = 4.0, .kind = EventKind::prompt});
  EXPECT_TRUE(front.urgent()) << "what happened does not wait";
}

TEST(Recorder, ContinuesAStoreAndItsNumbers) {
  const ScratchFolder folder;
  Disk disk;
  GivenItems items;
  auto options = small_options(false);
  for (int part = 0; part < 3; ++part) {
    Recorder recorder(folder.path, disk, options);
    if (part == 0) begin_run(recorder);
    for (int k = 100 * part; k < 100 * (part + 1); ++k) add_step(recorder, k, items);
    options.resume = true;
  }
  EXPECT_EQ(items_of_store(folder.path), items);
  EXPECT_EQ(items.rbegin()->first, items.size());
}

TEST(Recorder, RefusesASecondWriterAndAStoreThatIsThere) {
  const ScratchFolder folder;
  const std::string store = folder.file("live.sqlite");
  Disk disk;
  auto options = small_options(true);
  {
    Recorder recorder(folder.path, disk, options);
    begin_run(recorder);
    recorder.flush();
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {store}, .pattern = "still being recorded"},
                        [&] { visit_store(folder.path, {}); }));
    options.resume = true;
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {store}, .pattern = "one process writes a store"},
                        [&] { Recorder second(folder.path, disk, options); }));
  }
  options.resume = false;
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {store, folder.path}, .pattern = "tumble seal"},
                      [&] { Recorder second(folder.path, disk, options); }));
}

TEST(Recorder, StopsWithAReasonWhenMoreWaitsThanMay) {
  const ScratchFolder folder;
  Disk disk;
  auto options = small_options(false);
  options.queue_bytes = 10000;
  int failures = 0;
  options.on_failure = [&](const StoreFailure&) { ++failures; };
  GivenItems items;
  Recorder recorder(folder.path, disk, options);
  begin_run(recorder);
  for (int k = 0; k < 1000; ++k) add_step(recorder, k, items);
  EXPECT_FALSE(recorder.flush());
  ASSERT_TRUE(recorder.failure());
  EXPECT_EQ(recorder.failure()->kind, StoreFailure::Kind::overflow);
  EXPECT_EQ(failures, 1);
  EXPECT_LT(items.size(), 1000u);
  EXPECT_EQ(recorder.close(10.0, "stopped"), false);
  auto stored = items_of_store(folder.path);
  EXPECT_EQ(stored.rbegin()->second.bytes, recorder.failure()->text.text());
  stored.erase(std::prev(stored.end()));
  EXPECT_EQ(stored, items) << "what was accepted is kept";
}

TEST(Recorder, RefusesToBeginWithoutRoom) {
  const ScratchFolder folder;
  Disk disk;
  auto options = small_options(false);
  options.floor_bytes = std::uint64_t{1} << 60;
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.path}, .pattern = "has room for"},
                      [&] { Recorder recorder(folder.path, disk, options); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("none")}, .pattern = "no such folder"},
                      [&] { Recorder recorder(folder.file("none"), disk, options); }));
}

TEST(Recorder, CopiesItsLogBackWhileItRuns) {
  const ScratchFolder folder;
  Disk disk;
  auto options = small_options(false);
  options.checkpoint_bytes = 1 << 20;
  Recorder recorder(folder.path, disk, options);
  begin_run(recorder);
  for (int k = 0; k < 200; ++k) {
    recorder.raw(0, StoreDirection::received, k, std::string(options.chunk_bytes, 'x'));
    ASSERT_TRUE(recorder.flush());
  }
  // A commit is two chunks at most, and the log begins again after the checkpoint.
  EXPECT_LT(std::filesystem::file_size(folder.file("live.sqlite-wal")), 2u << 20);
  EXPECT_GT(std::filesystem::file_size(folder.file("live.sqlite")), 11u << 20);
}

TEST(Recorder, RefusesToReadWhatIsNoStore) {
  const ScratchFolder folder;
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.path, "live.sqlite"}},
                      [&] { visit_store(folder.path, {}); }));
  { std::ofstream(folder.file("live.sqlite")) << std::string(5000, 'x'); }
  EXPECT_TRUE(refuses(Error::Kind::bad_file,
                      Asked{.values = {folder.file("live.sqlite")}, .pattern = "cannot be read as a live store"},
                      [&] { visit_store(folder.path, {}); }));
}

}  // namespace
}  // namespace tumble
