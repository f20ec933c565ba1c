#include "tumble/recorder/recorder_read.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/recorder_stream.hpp"
#include "tumble/recorder/testing/faulty_disk.hpp"
#include "tumble/recorder/testing/frame_source.hpp"
#include "tumble/recorder/testing/small_run.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using testing::DiskFault;
using testing::FaultyDisk;

RecorderOptions quiet_options() {
  RecorderOptions options;
  options.background = false;
  options.reserve_bytes = 0;
  return options;
}

StoreLink kvh_link(const std::string& slot = "") {
  const auto& shipped = find_instrument("kvh_1775");
  return {"tcp:127.0.0.1:4001", slot, std::string(shipped.text), "kvh_1775", {}};
}

const Finding* finding_of(const Recording& recording, const std::string& code) {
  const auto found = std::ranges::find(recording.findings, code, &Finding::code);
  return found == recording.findings.end() ? nullptr : &*found;
}

std::size_t missing_in(const Channel& channel) {
  return static_cast<std::size_t>(std::ranges::count_if(channel.values, [](double x) { return std::isnan(x); }));
}

/// A stream of 10 s at 1000 Hz that arrives in packets every 16 ms, 0 to 3 ms late; `change` may damage a frame.
template <class Change>
void record_stream(const std::string& folder, Change change, const std::string& ending = "complete") {
  Disk disk;
  Recorder recorder(folder, disk, quiet_options());
  FrameSource source("kvh_1775", "B");
  InstrumentRecorder instrument(recorder, source.codec, kvh_link());
  std::mt19937_64 random(7);
  std::string packet;
  for (int k = 0; k < 10000; ++k) {
    std::string frame = source.next();
    change(k, frame);
    packet += frame;
    if (k % 16 != 15) continue;
    const double late = 0.003 * static_cast<double>(random() >> 11) * 0x1p-53;
    ASSERT_TRUE(instrument.receive(100.0 + 0.001 * k + late, packet));
    packet.clear();
    if (k % 512 == 15) recorder.flush();
  }
  if (!ending.empty()) recorder.close(110.0, say("{}", Name{ending}));
}

TEST(StoreReader, GivesAnEvenClockWithoutTheJitterOfTheArrival) {
  const ScratchFolder folder;
  record_stream(folder.path, [](int, std::string&) {});
  const auto recordings = read_store(folder.path);
  ASSERT_EQ(recordings.size(), 1u);
  const Recording& recording = recordings[0].recording;
  const Channel* gyro = find_channel(recording, "gyro.x");
  ASSERT_NE(gyro, nullptr);
  ASSERT_TRUE(gyro->timeline.uniform());
  EXPECT_NEAR(gyro->timeline.rate, 1000.0, 1e-6) << "the clock of the device, which the arrival does not contradict";
  // The last sample of a packet arrives 0 to 3 ms after it was taken; of 625 packets the earliest is 5 us late on
  // average.
  EXPECT_NEAR(gyro->timeline.start, 100.0 - 0.001, 5e-5) << "a sample begins one interval before it is complete";
  EXPECT_EQ(gyro->values.size(), 10000u);
  // An increment of 1e-5 rad a sample with noise of 1e-6: times 1000 Hz, its mean is good to 1e-3/sqrt(10000).
  const double mean = std::accumulate(gyro->values.begin(), gyro->values.end(), 0.0) / 10000.0;
  EXPECT_NEAR(mean, 0.01, 4e-5);
  EXPECT_TRUE(recording.findings.empty()) << recording.findings[0].message;
}

TEST(StoreReader, CountsLostRepeatedAndDamagedFramesExactly) {
  const ScratchFolder folder;
  std::mt19937_64 random(3);
  std::size_t lost = 0, damaged = 0, repeated = 0;
  std::vector<int> gone;
  record_stream(folder.path, [&](int k, std::string& frame) {
    if (k < 5 || k > 9900) return;  // the loss of a first or last frame cannot be seen
    const auto draw = random() % 100;
    if (draw == 0) {
      frame.clear();
      gone.push_back(k);
      ++lost;
    } else if (draw == 1) {
      frame[20] = static_cast<char>(frame[20] ^ 0x10);
      gone.push_back(k);
      ++damaged;
    } else if (draw == 2) {
      frame += frame;
      ++repeated;
    }
  });
  const auto recordings = read_store(folder.path);
  const Recording& recording = recordings.at(0).recording;
  ASSERT_TRUE(finding_of(recording, "frames_damaged") && finding_of(recording, "frames_repeated") &&
              finding_of(recording, "frames_lost"));
  EXPECT_EQ(finding_of(recording, "frames_damaged")->occurrences.count, damaged);
  EXPECT_EQ(finding_of(recording, "frames_repeated")->occurrences.count, repeated);
  EXPECT_EQ(std::get<long long>(finding_of(recording, "frames_lost")->values[0].value),
            static_cast<long long>(lost + damaged));
  const Channel& gyro = *find_channel(recording, "gyro.x");
  ASSERT_EQ(gyro.values.size(), 10000u);
  EXPECT_EQ(missing_in(gyro), gone.size());
  for (const int k : gone) EXPECT_TRUE(std::isnan(gyro.values[static_cast<std::size_t>(k)])) << k;
}

TEST(StoreReader, SaysThatARecordingWasInterrupted) {
  const ScratchFolder folder;
  record_stream(
      folder.path, [](int, std::string&) {}, "");
  const auto recordings = read_store(folder.path);
  ASSERT_NE(finding_of(recordings.at(0).recording, "recording_interrupted"), nullptr);
  EXPECT_EQ(find_channel(recordings[0].recording, "gyro.x")->values.size(), 10000u);
}

TEST(StoreReader, FollowsAClockThatRunsFast) {
  const ScratchFolder folder;
  {
    Disk disk;
    Recorder recorder(folder.path, disk, quiet_options());
    FrameSource source("kvh_1775", "B");
    InstrumentRecorder instrument(recorder, source.codec, kvh_link());
    // 50 ppm fast; a line through 60 s with an arrival within 2 ms shows this many times over.
    for (int k = 0; k < 60000; ++k)
      instrument.receive(0.001 * k / 1.00005 + 0.002 * (k * 37 % 100) / 100.0, source.next());
    recorder.close(60.0, "complete");
  }
  const auto recordings = read_store(folder.path);
  // Standard deviation of the slope: 0.6 ms sqrt(12/60000)/60 s, 0.14 ppm.
  EXPECT_NEAR(find_channel(recordings.at(0).recording, "gyro.x")->timeline.rate, 1000.05, 1000.0 * 4 * 0.14e-6);
}

TEST(StoreReader, MarksTheLastFinishedAttempts) {
  const ScratchFolder folder;
  {
    Disk disk;
    Recorder recorder(folder.path, disk, quiet_options());
    GivenItems items;
    begin_run(recorder);
    const auto row = [&](double time, const char* segment, int attempt, RunRow::Kind kind, bool finished = false) {
      RunRow written{.kind = kind, .time = time, .attempt = attempt, .label = segment};
      if (finished) written.ending = RunRow::Ending::complete;
      recorder.journal(time, written);
    };
    constexpr auto begins = RunRow::Kind::segment_begins, ends = RunRow::Kind::segment_ends;
    constexpr auto records = RunRow::Kind::records, pauses = RunRow::Kind::pauses;
    for (int k = 0; k < 30; ++k)
      recorder.sample(0, {0.01 * k, {}, static_cast<std::uint64_t>(k), std::vector{1.0, 2.0, 3.0}});
    row(0.00, "up", 1, begins), row(0.01, "up", 1, records), row(0.02, "up", 1, ends, true);
    row(0.03, "up", 2, begins), row(0.04, "up", 2, records), row(0.05, "up", 2, ends, false);
    row(0.06, "down", 1, begins), row(0.07, "down", 1, records), row(0.08, "down", 1, ends, false);
    row(0.09, "down", 2, begins), row(0.10, "down", 2, records), row(0.12, "down", 2, pauses);
    row(0.13, "down", 2, records), row(0.15, "down", 2, pauses), row(0.16, "down", 2, ends, true);
    row(0.17, "side", 1, begins), row(0.18, "side", 1, records);
    recorder.close(0.3, "aborted");
  }
  const auto recordings = read_store(folder.path);
  const auto& marks = recordings.at(0).recording.marks;
  ASSERT_EQ(marks.size(), 3u);
  EXPECT_EQ(marks[0].label, "up");
  EXPECT_EQ(marks[0].begin, 0.01);
  EXPECT_EQ(marks[0].end, 0.02);
  EXPECT_EQ(marks[1].label, "down");
  EXPECT_EQ(marks[1].begin, 0.10);
  EXPECT_EQ(marks[2].begin, 0.13);
  EXPECT_EQ(marks[2].end, 0.15);
}

TEST(StoreReader, KeepsEveryStampWhereALinkCameBack) {
  const ScratchFolder folder;
  {
    Disk disk;
    Recorder recorder(folder.path, disk, quiet_options());
    FrameSource source("kvh_1775", "B");
    InstrumentRecorder instrument(recorder, source.codec, kvh_link());
    for (int k = 0; k < 100; ++k) instrument.receive(0.001 * k, source.next());
    recorder.event({0.1, EventKind::link_lost, "tcp:127.0.0.1:4001", "closed", {}});
    instrument.restart();
    for (int k = 0; k < 100; ++k) instrument.receive(5.0 + 0.001 * k, source.next());
    recorder.close(6.0, "complete");
  }
  const auto recordings = read_store(folder.path);
  const Channel& gyro = *find_channel(recordings.at(0).recording, "gyro.x");
  EXPECT_FALSE(gyro.timeline.uniform());
  ASSERT_EQ(gyro.values.size(), 200u);
  EXPECT_EQ(gyro.time(100), 5.0);
  ASSERT_NE(finding_of(recordings[0].recording, "recording_link_lost"), nullptr);
}

TEST(StoreReader, NoticesADamagedChunk) {
  const ScratchFolder folder;
  record_stream(folder.path, [](int, std::string&) {});
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(folder.file("live.sqlite").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database,
                         "UPDATE chunk SET body = zeroblob(length(body)) WHERE first = (SELECT first FROM chunk WHERE "
                         "kind = 1 LIMIT 1 OFFSET 5)",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  const auto recordings = read_store(folder.path);
  const Finding* finding = finding_of(recordings.at(0).recording, "recording_damaged");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->occurrences.count, 1u);
  EXPECT_GT(missing_in(*find_channel(recordings[0].recording, "gyro.x")), 100u);
}

void run_sql(const std::string& file, const char* statement) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, statement, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
}

std::string version_of(const std::string& file) {
  std::string version;
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  const auto take = [](void* out, int, char** values, char**) {
    *static_cast<std::string*>(out) = values[0];
    return 0;
  };
  EXPECT_EQ(sqlite3_exec(database, "PRAGMA user_version", take, &version, nullptr), SQLITE_OK);
  sqlite3_close(database);
  return version;
}

TEST(StoreReader, ReadsStoresOfBothVersionsAndRefusesOthers) {
  const ScratchFolder folder;
  record_stream(
      folder.path, [](int, std::string&) {}, "");
  const std::string file = folder.file("live.sqlite");
  EXPECT_EQ(version_of(file), "2");
  run_sql(file, "PRAGMA user_version = 1");
  EXPECT_EQ(read_store(folder.path).size(), 1u);
  EXPECT_EQ(version_of(file), "1") << "who reads changes nothing";
  {
    Disk disk;
    RecorderOptions options = quiet_options();
    options.resume = true;
    const Recorder recorder(folder.path, disk, options);
  }
  EXPECT_EQ(version_of(file), "2");
  run_sql(file, "PRAGMA user_version = 3");
  try {
    read_store(folder.path);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_file);
  }
}

TEST(Seal, WritesTheSameBytesTwice) {
  const ScratchFolder folder;
  record_stream(folder.path, [](int k, std::string& frame) {
    if (k == 50) frame.clear();
  });
  Disk disk;
  const auto first = seal(folder.path, disk);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].path, folder.file("recording.h5"));
  const std::string bytes = read_text_file(first[0].path);
  std::filesystem::remove(first[0].path);
  const auto second = seal(folder.path, disk);
  EXPECT_EQ(read_text_file(second.at(0).path), bytes);
  EXPECT_EQ(sha256_of(bytes), first[0].sha256);
  const auto content = visit_store(folder.path, [](const StoreItem&) {});
  EXPECT_EQ(content.facts.at("sealed"), first[0].sha256);
  const Recording back = read_recording(first[0].path, {}, {});
  const auto live = read_store(folder.path);
  EXPECT_EQ(find_channel(back, "gyro.x")->values.size(), find_channel(live[0].recording, "gyro.x")->values.size());
  EXPECT_EQ(folder.entries(), 2u) << "no part remains";
}

TEST(Seal, GivesEachUnitAFile) {
  const ScratchFolder folder;
  {
    Disk disk;
    Recorder recorder(folder.path, disk, quiet_options());
    FrameSource source("kvh_1775", "B");
    InstrumentRecorder one(recorder, source.codec, kvh_link("left")), two(recorder, source.codec, kvh_link("right"));
    for (int k = 0; k < 100; ++k) {
      const std::string frame = source.next();
      one.receive(0.001 * k, frame);
      if (k < 40) two.receive(0.001 * k, frame);
    }
    recorder.close(0.1, "complete");
  }
  Disk disk;
  const auto sealed = seal(folder.path, disk);
  ASSERT_EQ(sealed.size(), 2u);
  EXPECT_EQ(sealed[0].path, folder.file("recording-left.h5"));
  EXPECT_EQ(find_channel(read_recording(sealed[0].path, {}, {}), "gyro.x")->values.size(), 100u);
  EXPECT_EQ(find_channel(read_recording(sealed[1].path, {}, {}), "gyro.x")->values.size(), 40u);
}

/// What a seal leaves after a fault at each call: the file whole or not there, and a store that can be sealed again.
void expect_sealed_again(DiskFault::Kind kind) {
  const ScratchFolder source;
  {
    Disk disk;
    Recorder recorder(source.path, disk, quiet_options());
    GivenItems items;
    begin_run(recorder);
    for (int k = 0; k < 200; ++k) add_step(recorder, k, items);
    recorder.close(2.0, "complete");
  }
  const auto copied = [&](const ScratchFolder& folder) {
    std::filesystem::copy(source.path, folder.path, std::filesystem::copy_options::recursive);
  };
  std::uint64_t calls = 0;
  std::string sha256;
  {
    const ScratchFolder folder;
    copied(folder);
    FaultyDisk disk;
    sha256 = seal(folder.path, disk).at(0).sha256;
    calls = disk.calls();
  }
  ASSERT_GT(calls, 5u);
  for (std::uint64_t at = 1; at <= calls; ++at) {
    const ScratchFolder folder;
    copied(folder);
    {
      FaultyDisk disk({kind, at, at});
      try {
        seal(folder.path, disk);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind, Error::Kind::bad_file) << error.what();
      }
      if (kind == DiskFault::Kind::crash) disk.power_cut();
    }
    if (std::filesystem::exists(folder.file("recording.h5"))) {
      EXPECT_EQ(sha256_of_file(folder.file("recording.h5")), sha256) << "call " << at;
    }
    Disk disk;
    EXPECT_EQ(seal(folder.path, disk).at(0).sha256, sha256) << "call " << at;
  }
}

TEST(Seal, LeavesAWholeFileOrNoneAfterAPowerCutAtAnyCall) { expect_sealed_again(DiskFault::Kind::crash); }
TEST(Seal, LeavesAWholeFileOrNoneAfterAFailureOfAnyCall) { expect_sealed_again(DiskFault::Kind::fails); }
TEST(Seal, LeavesAWholeFileOrNoneOnAFullDisk) { expect_sealed_again(DiskFault::Kind::full); }

TEST(LiveNoise, GivesMeanDeviationAndAllanDeviationOfWhiteNoise) {
  LiveNoise noise(1.0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(3.0, 0.5);
  const int rate = 100, seconds = 2000;
  std::vector<double> values;
  for (int k = 0; k < rate * seconds; ++k) {
    values.push_back(normal(random));
    noise.add(static_cast<double>(k) / rate, values.back());
  }
  EXPECT_NEAR(noise.mean(), 3.0, 4 * 0.5 / std::sqrt(200000.0));
  EXPECT_NEAR(noise.sd(), 0.5, 4 * 0.5 / std::sqrt(2 * 200000.0));
  // sigma(1 s) = 0.5/sqrt(100); of 2000 means the deviation is good to about 1/sqrt(2 * 2000/1.5).
  EXPECT_NEAR(noise.allan(), 0.05, 4 * 0.05 / std::sqrt(2 * 2000 / 1.5));
  EXPECT_TRUE(std::isnan(LiveNoise().allan()));
}

}  // namespace
}  // namespace tumble
