// Clocks that are set, and topics that are hard to name, on logs (MCAP, ROS 1 messages) that are made here.

#include <gtest/gtest.h>

#include <filesystem>

#include "tumble/formats/testing/log_files.hpp"

namespace tumble {
namespace {

constexpr std::int64_t second = 1'000'000'000, begin = 1'700'000'000 * second, step = 5'000'000;  // ns

std::string as_bytes(std::uint64_t value, std::size_t size) { return {reinterpret_cast<const char*>(&value), size}; }

std::string as_text(const std::string& text) { return as_bytes(text.size(), 4) + text; }

std::string record(char code, const std::string& content) {
  return std::string(1, code) + as_bytes(content.size(), 8) + content;
}

/// A log of one topic whose messages hold three numbers: the number of the message, 2, 3.
struct Mcap {
  std::string bytes;
  int count = 0;

  Mcap(const std::string& topic, const std::string& type) : bytes("\x89MCAP0\r\n") {
    bytes += record(1, as_text("") + as_text(""));
    bytes += record(3, as_bytes(1, 2) + as_text(type) + as_text("ros1msg") + as_text(""));
    bytes += record(4, as_bytes(0, 2) + as_bytes(1, 2) + as_text(topic) + as_text("ros1") + as_bytes(0, 4));
  }

  /// Given: header.stamp and the time of the recorder [ns].
  void add(std::int64_t stamp, std::int64_t received, std::size_t numbers = 3) {
    std::string body = as_bytes(0, 4) + as_bytes(static_cast<std::uint64_t>(stamp / second), 4) +
                       as_bytes(static_cast<std::uint64_t>(stamp % second), 4) + as_text("imu");
    for (std::size_t i = 0; i < numbers; ++i) {
      const double value = i == 0 ? count : static_cast<double>(i) + 1.0;
      body.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    const std::string time = as_bytes(static_cast<std::uint64_t>(received), 8);
    bytes += record(5, as_bytes(0, 2) + as_bytes(static_cast<std::uint64_t>(count++), 4) + time + time + body);
  }
};

constexpr const char* vector_type = "geometry_msgs/Vector3Stamped";

ReadOptions picking(const std::string& topic, const std::string& channel) {
  ReadOptions options;
  options.topics = {topic};
  for (const char* axis : {".x", ".y", ".z"}) options.units[channel + axis] = Unit::parse("rad/s");
  return options;
}

TEST(RosClock, AFirstStampOfZeroIsNoTimeWhereTheOthersDoNotFollow) {
  const ScratchFolder folder;
  Mcap log("/gyro", vector_type), simulated("/gyro", vector_type);
  for (int k = 0; k < 40; ++k) {
    log.add(k == 0 ? 0 : begin + k * step, begin + k * step);
    simulated.add(k * step, begin + k * step);
  }
  write_bytes(folder.file("a.mcap"), log.bytes);
  const Recording read = read_recording(folder.file("a.mcap"), picking("/gyro", "gyro"), {});
  EXPECT_NE(said(read.findings, "header_stamps_zero"), "");
  EXPECT_EQ(read.channels.at(0).timeline.rate, 200.0);
  write_bytes(folder.file("b.mcap"), simulated.bytes);  // a simulation begins at zero
  const Recording other = read_recording(folder.file("b.mcap"), picking("/gyro", "gyro"), {});
  EXPECT_EQ(said(other.findings, "header_stamps_zero"), "");
  EXPECT_EQ(other.channels.at(0).timeline.rate, 200.0);
}

TEST(RosClock, StretchesBetweenWhichTheClockWasSetBackAreNotMixed) {
  const ScratchFolder folder;
  Mcap set_back("/gyro", vector_type), swapped("/gyro", vector_type);
  for (int k = 0; k < 1000; ++k) {
    const std::int64_t back = k < 500 ? 0 : 2 * second, pair = begin + (k ^ 1) * step;
    set_back.add(begin + k * step - back, begin + k * step - back);
    swapped.add(pair, pair);
  }
  write_bytes(folder.file("a.mcap"), set_back.bytes);
  const Recording read = read_recording(folder.file("a.mcap"), picking("/gyro", "gyro"), {});
  for (std::size_t k = 0; k < 1000; ++k) ASSERT_EQ(read.channels.at(0).values.at(k), static_cast<double>(k));
  EXPECT_EQ(said(read.findings, "log_out_of_order"), "");
  write_bytes(folder.file("b.mcap"), swapped.bytes);
  const Recording sorted = read_recording(folder.file("b.mcap"), picking("/gyro", "gyro"), {});
  for (std::size_t k = 0; k < 1000; ++k) ASSERT_EQ(sorted.channels.at(0).values.at(k), static_cast<double>(k ^ 1));
  EXPECT_NE(said(sorted.findings, "log_out_of_order"), "");
}

TEST(RosTopics, NumbersWithoutAUnitAreAskedForWithWordsToCopy) {
  const ScratchFolder folder;
  Mcap log("/bench/gyro", vector_type);
  for (int k = 0; k < 4; ++k) log.add(begin + k * step, begin + k * step);
  write_bytes(folder.file("a.mcap"), log.bytes);
  const auto asked = refusal_of(folder.file("a.mcap"));
  EXPECT_TRUE(refuses(Error::Kind::bad_file,
                      Asked{.values = {"/bench/gyro", "bench.gyro"}, .pattern = "--set unit.{}.x=rad/s"}, asked));
  EXPECT_EQ(read_recording(folder.file("a.mcap"), picking("/bench/gyro", "bench.gyro"), {}).channels.size(), 3u);
}

TEST(RosTopics, ANameMayHaveAnyLetters) {
  const ScratchFolder folder;
  Mcap log("/陀螺/ü 1", vector_type);
  for (int k = 0; k < 4; ++k) log.add(begin + k * step, begin + k * step);
  write_bytes(folder.file("a.mcap"), log.bytes);
  const Recording read = read_recording(folder.file("a.mcap"), picking("/陀螺/ü 1", "陀螺.ü 1"), {});
  EXPECT_EQ(read.channels.at(0).name, "陀螺.ü 1.x");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"'/陀螺/ü 1'"}}, refusal_of(folder.file("a.mcap"))));
}

TEST(RosBag2, RowsInALogBesideTheDatabaseAreNotLeftOut) {
  const ScratchFolder folder;
  const std::string path = folder.file("a%20 b#?.db3");
  write_bytes(path, read_text_file(TUMBLE_SOURCE_DIR "/tests/reference/ros/plain.db3"));
  write_bytes(path + "-wal", "");
  EXPECT_FALSE(read_recording(path, {}, {}).channels.empty());
  EXPECT_FALSE(std::filesystem::exists(path + "-shm"));
  write_bytes(path + "-wal", "rows");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {path, "-wal"}}, refusal_of(path)));
}

}  // namespace
}  // namespace tumble
