#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace {

/// A stream of frames of a shipped declaration, as its instrument would send it.
struct Sender {
  FrameCodec codec;
  std::size_t frame = 0;
  std::string bytes = {};
  FrameContent content = {};

  Sender(const std::string& name, const std::string& layout, const std::vector<std::string>& variants = {})
      : codec(codec_of(find_instrument(name), variants)) {
    while (codec.frames[frame].name != layout) ++frame;
    content = {frame, std::vector<double>(codec.channels.size()), std::vector<unsigned char>(codec.channels.size())};
    for (const FrameField& field : codec.frames[frame].fields)
      if (!field.when) content.present[field.channel] = 1;
  }
  void set(const std::string& channel, double si) {
    for (std::size_t i = 0; i < codec.channels.size(); ++i)
      if (codec.channels[i].name == channel) content.values[i] = si, content.present[i] = 1;
  }
  void send() { bytes += encode_frame(codec, content); }
};

std::string put(const ScratchFolder& folder, const std::string& name, const std::string& bytes) {
  const std::string path = folder.file(name);
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

/// KVH format B at 1000 Hz: increments of 1e-5 rad, with the time of the device; frames in `lost` are not sent.
std::string kvh_stream(int frames, const std::vector<int>& lost = {}) {
  Sender kvh("kvh_1775", "B");
  kvh.set("temperature", si(25.0, "degC"));
  for (int i = 0; i < frames; ++i) {
    kvh.set("gyro.x", static_cast<float>(1e-5));
    kvh.set("acc.z", si(1.0, "g"));
    kvh.content.counter = static_cast<std::uint64_t>(i % 128);
    kvh.content.time = 2.0 + 0.001 * i;
    if (std::ranges::find(lost, i) == lost.end()) kvh.send();
  }
  return kvh.bytes;
}

bool has_finding(const Recording& recording, const std::string& code) {
  return std::ranges::any_of(recording.findings, [&](const Finding& finding) { return finding.code == code; });
}

TEST(FramesFormat, RecognisesTheDeviceAndDividesIncrementsByTheTimeOfASample) {
  const ScratchFolder folder;
  const auto path = put(folder, "kvh.bin", kvh_stream(500));
  EXPECT_STREQ(format_of(path).name, "frames");
  const Recording recording = read_recording(path, {}, {});
  const Channel* gyro = find_channel(recording, "gyro.x");
  ASSERT_NE(gyro, nullptr);
  ASSERT_EQ(gyro->values.size(), 500u);
  EXPECT_EQ(gyro->unit.text(), "rad/s");
  EXPECT_EQ(gyro->kind, QuantityKind::angular_rate);
  ASSERT_TRUE(gyro->timeline.uniform());
  EXPECT_DOUBLE_EQ(gyro->timeline.rate, 1000.0);
  EXPECT_DOUBLE_EQ(gyro->timeline.start, 2.0);
  EXPECT_DOUBLE_EQ(gyro->values[17], 1000.0 * static_cast<float>(1e-5));
  EXPECT_DOUBLE_EQ(find_channel(recording, "acc.z")->values[0], standard_gravity);
  EXPECT_TRUE(has_finding(recording, "frames_recognised"));
}

TEST(FramesFormat, ShowsLostFramesInTheStamps) {
  const ScratchFolder folder;
  const auto path = put(folder, "kvh.bin", kvh_stream(500, {100, 101, 102}));
  const Recording recording = read_recording(path, {}, {});
  const Channel* gyro = find_channel(recording, "gyro.x");
  ASSERT_EQ(gyro->values.size(), 497u);
  ASSERT_FALSE(gyro->timeline.uniform());
  EXPECT_NEAR(gyro->time(100) - gyro->time(99), 0.004, 1e-9);
  EXPECT_NEAR(gyro->values[300], 1000.0 * 1e-5, 1e-8) << "the rate is that of the samples, not that of the file";
  EXPECT_TRUE(has_finding(recording, "frames_lost"));
}

TEST(FramesFormat, CountsTimeByTheCounterWhereTheFramesHaveNone) {
  const ScratchFolder folder;
  Sender stim("stim300", "93");
  for (int i = 0; i < 400; ++i) {
    if (i == 200) continue;
    stim.content.counter = static_cast<std::uint64_t>(4 * i % 256);
    stim.set("gyro.y", si(0.5, "deg/s"));
    stim.send();
  }
  const auto path = put(folder, "stim.bin", stim.bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "give their rate"}, [&] {
    read_recording(path, {}, {});
  })) << "without time a rate is needed";
  ReadOptions options;
  options.rate = 500.0;
  const Recording recording = read_recording(path, options, {});
  const Channel* gyro = find_channel(recording, "gyro.y");
  ASSERT_EQ(gyro->values.size(), 399u);
  EXPECT_NEAR(gyro->time(398), 399.0 / 500.0, 1e-12);
  EXPECT_DOUBLE_EQ(gyro->values[0], si(0.5, "deg/s"));
}

TEST(FramesFormat, KeepsChannelsOfSomeFramesOnAClockOfTheirOwn) {
  const ScratchFolder folder;
  Sender control("hg4930", "control"), inertial("hg4930", "inertial");
  std::string bytes;
  for (std::uint64_t i = 0; i < 600; ++i) {
    Sender& one = i % 6 == 5 ? inertial : control;
    one.content.counter = i % 4;
    if (&one == &inertial) one.set("angle.x", 1e-3);
    one.bytes.clear();
    one.send();
    bytes += one.bytes;
  }
  const Recording recording = read_recording(put(folder, "hg.bin", bytes), {}, {});
  EXPECT_EQ(find_channel(recording, "gyro.x")->values.size(), 600u);
  const Channel* angle = find_channel(recording, "angle.x");
  ASSERT_NE(angle, nullptr);
  EXPECT_EQ(angle->values.size(), 100u);
  EXPECT_NEAR(mean_rate(*angle), 100.0, 1e-9);
  EXPECT_NEAR(angle->values[5], 0.1, 100.0 * 0x1p-34) << "half a step, at 100 Hz";
}

TEST(FramesFormat, StreamsWhatItReads) {
  const ScratchFolder folder;
  const auto path = put(folder, "kvh.bin", "noise" + kvh_stream(5000, {77, 4000}) + "tail");
  const Recording whole = read_recording(path, {}, {});
  std::vector<double> values, times;
  stream_recording(format_of(path), path, {}, 100,
                   [&](const Recording& block) {
                     const Channel* gyro = find_channel(block, "gyro.x");
                     ASSERT_LE(gyro->values.size(), 100u);
                     for (std::size_t i = 0; i < gyro->values.size(); ++i)
                       values.push_back(gyro->values[i]), times.push_back(gyro->time(i));
                   },
                   {});
  const Channel* gyro = find_channel(whole, "gyro.x");
  EXPECT_EQ(values, gyro->values);
  ASSERT_EQ(times.size(), gyro->values.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], gyro->time(i));
  EXPECT_NEAR(static_cast<double>(recording_memory(format_of(path), path, {})),
              static_cast<double>(9 * sizeof(double) * values.size()), 0.2 * 9.0 * 8.0 * 5000.0)
      << "8 channels and a stamp";
}

TEST(FramesFormat, AsksForTheVariantThatTheFramesDoNotSay) {
  const ScratchFolder folder;
  Sender novatel("novatel_rawimu", "RAWIMUS", {"adis16488"});
  for (int i = 0; i < 10; ++i) {
    novatel.content.time = 1000.0 + 0.005 * i;
    novatel.set("gyro.y", si(720.0 * 0x1p-31, "deg"));
    novatel.send();
  }
  const auto path = put(folder, "novatel.bin", novatel.bytes);
  try {
    read_recording(path, {}, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--set frames=novatel_rawimu:"), std::string::npos) << error.what();
  }
  ReadOptions options;
  options.frames = "novatel_rawimu:adis16488";
  const Recording recording = read_recording(path, options, {});
  EXPECT_NEAR(find_channel(recording, "gyro.y")->values[3], 200.0 * si(720.0 * 0x1p-31, "deg"), 1e-15);
}

TEST(FramesFormat, ListsTheCandidatesWhereNoneExplainsTheBytes) {
  const ScratchFolder folder;
  std::mt19937_64 random(3);
  std::string bytes = kvh_stream(20);
  for (int i = 0; i < 5000; ++i) bytes += static_cast<char>(random() % 256);
  const auto path = put(folder, "mixed.raw", bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "kvh_1775", .pattern = "nearest are"},
                      [&] { read_recording(path, {}, {}); }));
  ReadOptions options;
  options.frames = "kvh_1775";
  EXPECT_EQ(find_channel(read_recording(path, options, {}), "gyro.x")->values.size(), 20u);
  options.frames = "kvh_1757";
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"kvh_1757", "kvh_1775"}},
                      [&] { read_recording(path, options, {}); }));
}

}  // namespace
}  // namespace tumble
