// The readers of rosbag, rosbag2 and mcap on files that the reference libraries wrote (tests/reference/ros).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "tumble/core/testing/asserts.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/ros/message.hpp"
#include "tumble/formats/testing/log_files.hpp"
#include "tumble/formats/topics/clock.hpp"

namespace tumble {
namespace {

const std::string folder = TUMBLE_SOURCE_DIR "/tests/reference/ros/";
const char* const all_files[] = {"plain.bag",      "lz4.bag",       "bz2.bag",         "plain.db3",
                                 "plain.mcap",     "lz4.mcap",      "zstd.mcap",       "ros1.mcap",
                                 "unchunked.mcap", "no_index.mcap", "ros2_writer.mcap"};
const char* const all_channels[] = {"gyro.x",          "gyro.y",          "gyro.z",
                                    "accelerometer.x", "accelerometer.y", "accelerometer.z"};

/// The columns of expected.csv.
std::vector<std::vector<double>> expected() {
  std::ifstream file(folder + "expected.csv");
  std::vector<std::vector<double>> columns(6);
  std::string line, cell;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    for (auto& column : columns) {
      std::getline(cells, cell, ',');
      column.push_back(std::stod(cell));
    }
  }
  return columns;
}

Recording read(const std::string& path, std::vector<std::string> topics = {}) {
  ReadOptions options;
  options.topics = std::move(topics);
  return read_recording(path, options, {});
}

const Finding* find(const Recording& recording, const std::string& code) {
  for (const auto& finding : recording.findings)
    if (finding.code == code) return &finding;
  return nullptr;
}

class RosFolders : public testing::TestWithParam<const char*> {};

TEST_P(RosFolders, FilesAreReadOneAfterTheOther) {
  const auto columns = expected();
  const std::string path = folder + GetParam();
  const Recording whole = read(path);
  std::vector<std::vector<double>> streamed(6);
  stream_recording(format_of(path), path, {}, 16,
                   [&](const Recording& block) {
                     for (std::size_t i = 0; i < 6; ++i)
                       streamed[i].insert(streamed[i].end(), block.channels[i].values.begin(),
                                          block.channels[i].values.end());
                   },
                   {});
  ASSERT_GE(whole.channels.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(whole.channels[i].name, all_channels[i]);
    EXPECT_EQ(whole.channels[i].values, columns[i]);
    EXPECT_EQ(streamed[i], columns[i]);
  }
  EXPECT_DOUBLE_EQ(whole.channels[0].timeline.rate, 200.0);
  EXPECT_EQ(find(whole, "log_out_of_order"), nullptr);
  EXPECT_EQ(read(path, {"/imu/mag"}).channels[0].values.size(), 30u);
}

TEST_P(RosFolders, TheChecksumKnowsEveryFile) {
  const ScratchFolder scratch;
  const std::string copy = scratch.file("bag"), kind = std::string(GetParam()).ends_with("mcap") ? ".mcap" : ".db3";
  std::filesystem::copy(folder + GetParam(), copy);
  const std::string whole = read(copy).origin.checksum();
  EXPECT_EQ(whole, read(folder + GetParam()).origin.checksum());
  std::filesystem::remove(copy + "/" + GetParam() + "_10" + kind);
  EXPECT_NE(whole, read(copy).origin.checksum());
  write_bytes(copy + "/packed" + kind + ".zstd", "");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "packed", .pattern = "zstd"}, [&] { read(copy); }));
}

INSTANTIATE_TEST_SUITE_P(All, RosFolders, testing::Values("split_db3", "split_mcap"));

class RosLogs : public testing::TestWithParam<const char*> {
 protected:
  std::string path() const { return folder + GetParam(); }
};

TEST_P(RosLogs, ImuIsReadBitByBit) {
  const Recording recording = read(path());
  const auto columns = expected();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Channel* channel = find_channel(recording, all_channels[i]);
    ASSERT_NE(channel, nullptr) << all_channels[i];
    EXPECT_EQ(channel->values, columns[i]) << all_channels[i];
    ASSERT_TRUE(channel->timeline.uniform());
    EXPECT_EQ(channel->timeline.rate, 200.0);
    EXPECT_EQ(channel->timeline.start, 0.0);
  }
  EXPECT_EQ(find_channel(recording, "gyro.x")->kind, QuantityKind::angular_rate);
  EXPECT_EQ(find_channel(recording, "accelerometer.x")->kind, QuantityKind::specific_force);
  EXPECT_EQ(recording.meta.at("epoch"), "1403636579.758555392 s (2014-06-24 19:02:59.758555392 UTC)");
  EXPECT_EQ(recording.meta.at("topic /imu/data"), "sensor_msgs/Imu");
  EXPECT_EQ(recording.meta.at("frame_id /imu/data"), "imu_link");
  EXPECT_NE(find(recording, "orientation_not_read"), nullptr);
  EXPECT_EQ(sha256_of(recording.origin).size(), 64u);
}

TEST_P(RosLogs, NoSoundFileIsAccused) {
  for (const Finding& finding : read(path()).findings)
    EXPECT_EQ(finding.severity, Finding::Severity::info) << finding.message;
}

TEST_P(RosLogs, BlocksHoldWhatTheWholeHolds) {
  const Recording whole = read(path());
  std::map<std::string, std::vector<double>> values, times;
  std::size_t findings = 0, blocks = 0;
  stream_recording(format_of(path()), path(), {}, 7,
                   [&](const Recording& block) {
                     ++blocks;
                     findings += block.findings.size();
                     ASSERT_EQ(block.channels.size(), whole.channels.size());
                     for (const Channel& channel : block.channels)
                       for (std::size_t i = 0; i < channel.values.size(); ++i) {
                         values[channel.name].push_back(channel.values[i]);
                         times[channel.name].push_back(channel.time(i));
                       }
                   },
                   {});
  EXPECT_EQ(findings, whole.findings.size());
  for (const Channel& channel : whole.channels) {
    EXPECT_EQ(values[channel.name], channel.values) << channel.name;
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      EXPECT_NEAR(times[channel.name].at(i), channel.time(i), 1e-12);  // rounding of the start of a block
  }
}

TEST_P(RosLogs, OnlyTheChannelsWanted) {
  ReadOptions options;
  options.only = {"accelerometer.y"};
  const Recording recording = read_recording(path(), options, {});
  ASSERT_EQ(recording.channels.size(), 1u);
  EXPECT_EQ(recording.channels[0].values, expected()[4]);
  options.only = {"gyros"};
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "gyro.x"}, [&] { read_recording(path(), options, {}); }));
}

TEST_P(RosLogs, MemoryIsThatOfTheSamples) {
  const std::uintmax_t bytes = recording_memory(format_of(path()), path(), {});
  EXPECT_GE(bytes, std::uintmax_t{6} * 60 * sizeof(double));
  EXPECT_LE(bytes, 60000u);
}

/// Cut at any byte, a file gives what stands before, or an Error that names it.
TEST_P(RosLogs, CutAnywhereGivesWhatIsThere) {
  const std::string whole = read_text_file(path());
  const std::vector<double> column = expected()[0];
  const ScratchFolder scratch;
  const std::string cut = scratch.file("cut" + std::string(GetParam()));
  std::size_t with_samples = 0;
  for (std::size_t size = 0; size < whole.size(); size += 131) {
    write_bytes(cut, whole.substr(0, size));
    try {
      const Recording recording = read(cut);
      const Channel* channel = find_channel(recording, "gyro.x");
      if (!channel) continue;  // the magnetometer alone
      ASSERT_LE(channel->values.size(), column.size());
      for (std::size_t i = 0; i < channel->values.size(); ++i) ASSERT_EQ(channel->values[i], column[i]) << size;
      EXPECT_FALSE(recording.findings.empty());
      ++with_samples;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("cut"), std::string::npos) << error.what();
    }
  }
  if (whole.starts_with("SQLite") || std::string(GetParam()) == "ros2_writer.mcap") return;  // all or nothing
  EXPECT_GT(with_samples, 10u);
}

TEST_P(RosLogs, TheCutIsReported) {
  const std::string whole = read_text_file(path());
  if (whole.starts_with("SQLite") || std::string(GetParam()) == "ros2_writer.mcap") return;  // one page, one frame
  const ScratchFolder scratch;
  const std::string cut = scratch.file("cut" + std::string(GetParam()));
  write_bytes(cut, whole.substr(0, whole.size() * 6 / 10));
  const Recording recording = read(cut);
  EXPECT_NE(find(recording, "log_ends_in_record"), nullptr);
  EXPECT_LT(find_channel(recording, "gyro.x")->values.size(), 60u);
}

INSTANTIATE_TEST_SUITE_P(All, RosLogs, testing::ValuesIn(all_files), [](const auto& entry) {
  std::string name = entry.param;
  std::ranges::replace(name, '.', '_');
  return name;
});

TEST(RosCompanions, ComeWithTheImu) {
  for (const char* file : {"plain.bag", "plain.db3", "zstd.mcap", "unchunked.mcap"}) {
    const Recording recording = read(folder + file);
    ASSERT_EQ(recording.channels.size(), 10u);
    const Channel* const magnetometer = find_channel(recording, "magnetometer.x");
    const Channel* const temperature = find_channel(recording, "temperature");
    ASSERT_EQ(magnetometer->values.size(), 30u);
    EXPECT_EQ(magnetometer->timeline.rate, 100.0);
    EXPECT_EQ(magnetometer->values[3], 1e-6 * 6);
    ASSERT_EQ(temperature->values.size(), 3u);
    EXPECT_EQ(temperature->values[1], 35.0 + 273.15);
    EXPECT_EQ(temperature->kind, QuantityKind::temperature);
    ASSERT_NE(find(recording, "topics_not_read"), nullptr);
    EXPECT_NE(find(recording, "topics_not_read")->message.find("/status (std_msgs/String"), std::string::npos);
  }
}

TEST(RosTopics, ANamedOneIsReadAlone) {
  const Recording recording = read(folder + "lz4.bag", {"imu/mag"});
  ASSERT_EQ(recording.channels.size(), 3u);
  EXPECT_EQ(recording.channels[0].name, "magnetometer.x");
  EXPECT_NE(find(recording, "topics_not_read")->message.find("/imu/data (sensor_msgs/Imu, 200 Hz, 60 messages)"),
            std::string::npos);
}

TEST(RosTopics, UnknownAndUnreadableOnesAreRefusedTogether) {
  const auto text = refusal_of([] { read(folder + "plain.mcap", {"/imu/dta", "/status"}); });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"/imu/dta", "/imu/data"}}, text));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "/status (std_msgs/String"}, text));
}

TEST(RosClock, ChoosesTheHeaderUnlessItIsWrong) {
  constexpr std::int64_t second = 1'000'000'000, begin = 1'400'000'000 * second;
  const auto choose = [&](std::int64_t first, double rate, std::string& code) {
    topics::ClockSummary clocks;
    for (int i = 0; i < 10'000; ++i) {
      const std::int64_t after = i * (second / 100);
      clocks.add(first + static_cast<std::int64_t>(rate * static_cast<double>(after)), begin + after);
    }
    Findings findings;
    const auto choice = topics::choose_clock(clocks, "/imu", findings);
    code = findings.empty() ? "" : findings.front().code;
    return choice;
  };
  std::string code;
  EXPECT_TRUE(choose(begin, 1.0, code).header);
  EXPECT_EQ(code, "");
  EXPECT_FALSE(choose(0, 0.0, code).header);
  EXPECT_EQ(code, "header_stamps_zero");
  EXPECT_FALSE(choose(begin, 0.0, code).header);
  EXPECT_EQ(code, "header_stamps_stand_still");
  EXPECT_FALSE(choose(begin, 1.02, code).header);
  EXPECT_EQ(code, "header_stamps_at_another_rate");
  EXPECT_TRUE(choose(begin, 5.0, code).header);
  EXPECT_EQ(code, "recorder_at_another_speed");
  const auto choice = choose(7 * second, 1.0, code);  // since the instrument was switched on
  EXPECT_TRUE(choice.header);
  EXPECT_EQ(code, "header_stamps_of_another_clock");
  EXPECT_EQ(choice.time(8 * second, 0), begin + second);
}

TEST(RosMessages, TypesAreNamedInThreeWays) {
  for (const char* name :
       {"sensor_msgs/Imu", "sensor_msgs/msg/Imu", "sensor_msgs::msg::Imu", "sensor_msgs::msg::dds_::Imu_"})
    EXPECT_EQ(ros::plain_type(name), "sensor_msgs/Imu");
  EXPECT_EQ(ros::plain_type("my_msgs/msg/Imu_"), "my_msgs/Imu_");
}

TEST(RosMessages, BothVersionsOfCdrAndBothByteOrders) {
  for (const char kind : {'\0', '\1', '\6', '\7'}) {
    std::string bytes{'\0', kind, '\0', '\0'};
    const bool reversed = kind % 2 == 0;
    const auto number = [&](auto value) {
      char raw[sizeof value];
      std::memcpy(raw, &value, sizeof value);
      if (reversed) std::reverse(raw, raw + sizeof value);
      bytes.append(raw, sizeof value);
    };
    number(std::int32_t{1});
    number(std::uint32_t{500});
    number(std::uint32_t{3});
    bytes += std::string("ab\0", 3);
    bytes.append(1, '\0');  // 15 -> 16 in both
    number(21.5);
    number(0.25);
    ros::Body body;
    ASSERT_TRUE(ros::decode(bytes, ros::Encoding::cdr, 2, body)) << static_cast<int>(kind);
    EXPECT_EQ(body.stamp, 1'000'000'500);
    EXPECT_EQ(body.frame, "ab");
    EXPECT_EQ(body.number(0), 21.5);
    EXPECT_EQ(body.number(1), 0.25);
    for (std::size_t size = 0; size < bytes.size(); ++size)
      EXPECT_FALSE(ros::decode(std::string_view(bytes).substr(0, size), ros::Encoding::cdr, 2, body));
  }
}

std::string little_endian(std::uint64_t value, std::size_t size) {
  return {reinterpret_cast<const char*>(&value), size};
}

TEST(RosTopics, SeveralImusAreAQuestionThatListsThem) {
  const std::string path = folder + "two_imus.bag";
  const auto text = refusal_of([&] { read(path); });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "/imu/data (sensor_msgs/Imu, 200 Hz, "}, text));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"/imu/data_raw"}, .pattern = "--topic"},
                      text));  // that of the driver is proposed
  EXPECT_EQ(read(path, {"/imu/data_raw"}).channels.front().name, "gyro.x");
  const Recording both = read(path, {"/imu/data_raw", "/imu/data"});
  ASSERT_EQ(both.channels.size(), 12u);
  EXPECT_EQ(both.channels[0].name, "imu.data_raw.gyro.x");
  EXPECT_EQ(both.channels[6].values, both.channels[0].values);
}

TEST(RosMessages, OfTwoFramesOnOneTopicAreReported) {
  const ScratchFolder scratch;
  std::string bytes = read_text_file(folder + "plain.bag");
  for (auto at = bytes.find("imu_link", bytes.size() / 2); at != bytes.npos; at = bytes.find("imu_link", at))
    bytes.replace(at, 8, "imu_left");
  write_bytes(scratch.file("two.bag"), bytes);
  EXPECT_TRUE(has_finding(read(scratch.file("two.bag")).findings, "messages_of_two_frames",
                          {{"first", "imu_link"}, {"other", "imu_left"}}));
}

TEST(RosClock, MessagesAreSortedOnlyWhereNeitherClockIsInOrder) {
  topics::ClockSummary clocks;
  for (const std::int64_t i : {1, 0, 3, 2}) clocks.add(10 + i, 100 + i);
  EXPECT_TRUE(clocks.out_of_order());
  clocks = {};
  for (const std::int64_t i : {0, 1, 2, 3}) clocks.add(10 + i, 100 + (i ^ 1));
  EXPECT_FALSE(clocks.out_of_order());
}

TEST(RosDamage, AWrongSizeOfAChunkCostsItsMessagesAlone) {
  const ScratchFolder scratch;
  for (const char* name : {"lz4.bag", "bz2.bag"}) {
    std::string bytes = read_text_file(folder + name);
    const std::size_t size = bytes.find("size=", bytes.find("size=") + 5) + 5;  // of the second chunk, unpacked
    for (const std::uint64_t wrong : {0ull, 100ull, 0xffffffffull}) {
      bytes.replace(size, 4, little_endian(wrong, 4));
      write_bytes(scratch.file("bad.bag"), bytes);
      const Recording recording = read(scratch.file("bad.bag"));
      ASSERT_NE(find(recording, "log_chunks_damaged"), nullptr) << name << wrong;
      EXPECT_GT(find_channel(recording, "gyro.x")->values.size(), 30u);
      EXPECT_LE(find_channel(recording, "gyro.x")->values.size(), 60u);
    }
  }
}

TEST(RosDamage, DamageInAChunkIsReportedWithItsPlace) {
  const ScratchFolder scratch;
  for (const char* name : {"lz4.mcap", "zstd.mcap", "bz2.bag", "lz4.bag"}) {
    std::string bytes = read_text_file(folder + name);
    for (std::size_t i = 0; i < 64; ++i) bytes[bytes.size() / 2 + i] = static_cast<char>(37 * i + 11);
    write_bytes(scratch.file(name), bytes);
    const Recording recording = read(scratch.file(name));
    EXPECT_TRUE(find(recording, "log_chunks_damaged") || find(recording, "log_records_damaged")) << name;
    const std::vector<double>& values = find_channel(recording, "gyro.x")->values;
    EXPECT_GT(values.size(), 10u);
    if (std::string(name).ends_with("bag")) continue;  // has no CRC
    const std::vector<double> sound = expected()[0];
    for (const double value : values) EXPECT_NE(std::ranges::find(sound, value), sound.end()) << name;
  }
}

TEST(RosDamage, WhereNothingCanBeReadTheErrorSaysWhy) {
  const ScratchFolder scratch;
  write_bytes(scratch.file("bad.mcap"),
              read_text_file(folder + "plain.mcap").substr(0, 8) + '\5' + std::string(108, '\xff'));
  const auto text = refusal_of([&] { read(scratch.file("bad.mcap")); });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "byte 8"}, text));
}

TEST(RosDatabase, AnotherDatabaseIsRefusedByItsTables) {
  std::string bytes = read_text_file(folder + "plain.db3");
  for (std::size_t at = 0; (at = bytes.find("messages", at)) != std::string::npos; ++at)
    bytes.replace(at, 8, "massages");
  const ScratchFolder scratch;
  write_bytes(scratch.file("other.db"), bytes);
  const auto text = refusal_of([&] { read(scratch.file("other.db")); });
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "massages"}, text));
}

}  // namespace
}  // namespace tumble
