// The logs of tests/reference/ulog, whose values follow from the number of the message (SOURCE.md), and damaged ones.

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "tumble/formats/testing/log_files.hpp"

namespace tumble {
namespace {

std::string reference(const char* name) { return std::string(TUMBLE_SOURCE_DIR "/tests/reference/ulog/") + name; }

std::vector<std::string> names_of(const Recording& recording) {
  std::vector<std::string> names;
  for (const Channel& channel : recording.channels) names.push_back(channel.name + "[" + channel.unit.text() + "]");
  return names;
}

std::string message(char type, const std::string& body) {
  const std::uint16_t size = static_cast<std::uint16_t>(body.size());
  std::string bytes(reinterpret_cast<const char*>(&size), 2);
  return bytes + type + body;
}

const std::string head = std::string("ULog\x01\x12\x35\x01", 8) + std::string(8, '\0');

TEST(ULog, ReadsTheRawSensorsWithTheTimesOfTheirSamples) {
  const Recording read = read_recording(reference("flight.ulg"), {}, {});
  EXPECT_EQ(names_of(read),
            (std::vector<std::string>{"gyro.x[rad/s]", "gyro.y[rad/s]", "gyro.z[rad/s]", "temperature[degC]",
                                      "accelerometer.x[m/s^2]", "accelerometer.y[m/s^2]", "accelerometer.z[m/s^2]",
                                      "temperature.accelerometer[degC]"}));
  ASSERT_EQ(read.channels[0].values.size(), 40u);
  for (std::size_t k = 0; k < 40; ++k) {
    const auto i = static_cast<double>(k);
    EXPECT_EQ(read.channels[0].values[k], static_cast<float>(0.001 * i));
    EXPECT_EQ(read.channels[1].values[k], static_cast<float>(-0.002 * i));
    EXPECT_EQ(read.channels[2].values[k], static_cast<float>(0.5 + i));
    EXPECT_EQ(read.channels[3].values[k], static_cast<float>(25 + 0.01 * i) + 273.15);
    EXPECT_EQ(read.channels[4].values[k], static_cast<float>(-0.001 * i));
    EXPECT_NEAR(read.channels[0].time(k), 1.0 + 0.001 * i - 0.00025, 1e-12);
  }
  EXPECT_EQ(read.channels[0].timeline.rate, 1000.0);
  EXPECT_EQ(read.instrument, "PX4 PX4_FMU_V6");
  EXPECT_EQ(read.meta.at("CAL_GYRO0_XOFF"), "0.25");
  EXPECT_EQ(read.meta.at("sensor_gyro:0"), "gyro.x = x, gyro.y = y, gyro.z = z, temperature = temperature");
  EXPECT_FALSE(read.meta.contains("TC_G0_X1_0"));
  EXPECT_FALSE(read.meta.contains("SYS_AUTOSTART"));
  EXPECT_NE(said(read.findings, "topics_not_read").find("sensor_gyro:1, sensor_combined:0, esc_status:0"),
            std::string::npos);
  EXPECT_NE(said(read.findings, "log_dropouts").find("for 12 ms"), std::string::npos);
  EXPECT_EQ(read.findings.size(), 2u);
}

TEST(ULog, ATopicIsPickedByName) {
  const Recording second = read_recording(reference("flight.ulg"), {.topics = {"sensor_gyro:1"}}, {});
  EXPECT_EQ(names_of(second).front(), "gyro.x[rad/s]");
  EXPECT_EQ(second.channels[0].values.at(3), static_cast<float>(0.002 * 6));
  const Recording both = read_recording(reference("flight.ulg"), {.topics = {"sensor_gyro"}}, {});
  EXPECT_EQ(names_of(both).at(4), "gyro1.x[rad/s]");
  EXPECT_EQ(names_of(both).at(7), "temperature.gyro[degC]");
  const Recording nested = read_recording(reference("flight.ulg"), {.topics = {"esc_status"}}, {});
  const Channel* current = find_channel(nested, "esc_status:0.esc.1.current.0");
  ASSERT_NE(current, nullptr);
  EXPECT_EQ(current->values.at(2), 16.0);
  EXPECT_NE(said(nested.findings, "unit_unknown").find("esc_status:0.count"), std::string::npos);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"sensor_giro", "sensor_gyro:0"}},
                      refusal_of(reference("flight.ulg"), ReadOptions{.topics = {"sensor_giro"}})));
}

TEST(ULog, CorrectedSamplesAreReadOnlyWithAWarning) {
  const Recording read = read_recording(reference("flight.ulg"), {.topics = {"sensor_combined"}}, {});
  EXPECT_EQ(names_of(read).at(5), "accelerometer.z[m/s^2]");
  EXPECT_EQ(read.channels[5].values.at(9), 9.5);
  EXPECT_NE(said(read.findings, "corrected_topic"), "");
}

TEST(ULog, TheAccelerometerOfACombinedTopicHasItsOwnTimes) {
  const Recording read = read_recording(reference("combined.ulg"), {}, {});
  ASSERT_EQ(names_of(read),
            (std::vector<std::string>{"gyro.x[rad/s]", "gyro.y[rad/s]", "gyro.z[rad/s]", "accelerometer.x[m/s^2]",
                                      "accelerometer.y[m/s^2]", "accelerometer.z[m/s^2]"}));
  const Channel& gyro = read.channels[0];
  const Channel& accelerometer = read.channels[4];
  ASSERT_EQ(gyro.values.size(), 24u);
  ASSERT_EQ(accelerometer.values.size(), 11u);  // every sample once, and none where the log says that there is none
  EXPECT_EQ(gyro.timeline.rate, 200.0);
  EXPECT_EQ(accelerometer.timeline.rate, 100.0);
  for (std::size_t k = 0; k < 11; ++k) {
    EXPECT_NEAR(accelerometer.time(k), 1.0 + 0.01 * static_cast<double>(k) - 0.00125, 1e-12);
    EXPECT_EQ(accelerometer.values[k], -0.5 * static_cast<double>(k));
  }
  EXPECT_EQ(read.meta.at("sensor_combined:0"),
            "gyro.x = gyro_rad.0, gyro.y = gyro_rad.1, gyro.z = gyro_rad.2, accelerometer.x = accelerometer_m_s2.0, "
            "accelerometer.y = accelerometer_m_s2.1, accelerometer.z = accelerometer_m_s2.2");
  expect_streams_the_same(reference("combined.ulg"), {}, 7);
  const Recording only = read_recording(reference("combined.ulg"), {.only = {"accelerometer.y"}}, {});
  ASSERT_EQ(only.channels.size(), 1u);
  EXPECT_EQ(only.channels[0].values, accelerometer.values);
}

TEST(ULog, BurstsAreSpreadOut) {
  const Recording read = read_recording(reference("bursts.ulg"), {}, {});
  ASSERT_EQ(read.channels.size(), 3u);
  ASSERT_EQ(read.channels[2].values.size(), 65u);  // five times 8 and five times 5
  EXPECT_EQ(read.channels[2].values[8], 2 * 100 * 0.0009765625);
  EXPECT_EQ(read.channels[1].values[12], -104 * 0.0009765625);
  EXPECT_NEAR(read.channels[0].time(12), 2.01 - 30e-6, 1e-12);  // the stamp is that of the last sample
  EXPECT_NEAR(read.channels[0].time(8), 2.01 - 30e-6 - 4 * 125e-6, 1e-12);
}

TEST(ULog, BlocksHoldWhatReadingGives) {
  expect_streams_the_same(reference("flight.ulg"), {}, 7);
  expect_streams_the_same(reference("bursts.ulg"), {}, 7);
  expect_streams_the_same(reference("flight.ulg"), {.topics = {"sensor_gyro", "esc_status"}}, 5);
}

TEST(ULog, AppendedDataAreNoSamples) {
  const Recording read = read_recording(reference("appended.ulg"), {}, {});
  EXPECT_EQ(read.channels[0].values.size(), 10u);
  EXPECT_TRUE(read.findings.empty());
}

TEST(ULog, AnUnknownFeatureIsRefused) {
  const ScratchFolder folder;
  std::string bytes = read_text_file(reference("flight.ulg"));
  bytes[16 + 3 + 8] = 2;
  write_bytes(folder.file("a.ulg"), bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "incompatible flags"}, refusal_of(folder.file("a.ulg"))));
}

TEST(ULog, CutAnywhereTheSamplesBeforeRemain) {
  const std::string bytes = read_text_file(reference("flight.ulg")).substr(0, 2300);
  expect_prefixes(bytes);
  const ScratchFolder folder;
  write_bytes(folder.file("a.ulg"), bytes.substr(0, 2250));
  EXPECT_NE(said(read_recording(folder.file("a.ulg"), {}, {}).findings, "log_cut_off"), "");
}

TEST(ULog, AfterDamageReadingGoesOn) {
  const ScratchFolder folder;
  const std::string good = read_text_file(reference("flight.ulg"));
  const Recording whole = read_recording(reference("flight.ulg"), {}, {});
  for (std::size_t at = 2000; at < 2200; at += 7) {
    std::string bytes = good;
    bytes.replace(at, 40, 40, '\xee');
    write_bytes(folder.file("a.ulg"), bytes);
    const Recording read = read_recording(folder.file("a.ulg"), {}, {});
    EXPECT_EQ(read.channels[0].values.back(), whole.channels[0].values.back()) << at;
    EXPECT_GE(read.channels[0].values.size(), 37u) << at;
  }
}

TEST(ULog, FormatsThatContainThemselvesAreNotRead) {
  const ScratchFolder folder;
  std::string bytes = head;
  for (const char* format : {"a:uint64_t timestamp;b inner;", "b:a inner;", "c:uint64_t timestamp;c[60000] again;",
                             "d:uint64_t timestamp;e[60000] many;", "e:f[60000] more;", "f:double[60000] most;"})
    bytes += message('F', format);
  for (const char* name : {"a", "c", "d", "nothing"}) bytes += message('A', std::string("\0\1\0", 3) + name);
  bytes += message('D', std::string(18, '\1'));
  write_bytes(folder.file("a.ulg"), bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "holds no samples"}, refusal_of(folder.file("a.ulg"))));
}

/// A message of `id` with a time [us] and one number.
std::string sample(char id, std::uint64_t time, float value) {
  std::string body(14, '\0');
  body[0] = id;
  std::memcpy(body.data() + 2, &time, 8);
  std::memcpy(body.data() + 10, &value, 4);
  return message('D', body);
}

TEST(ULog, AnIdThatIsGivenToAnotherTopicMeansThatFromThereOn) {
  const ScratchFolder folder;
  std::string bytes = head;
  for (const char* name : {"sensor_gyro", "sensor_accel"})
    bytes += message('F', std::string(name) + ":uint64_t timestamp;float x;");
  bytes += sample('\0', 999, 7);  // before its description: not read
  bytes += message('A', std::string("\0\0\0", 3) + "sensor_gyro");
  for (int k = 0; k < 5; ++k) bytes += sample('\0', 1000 + 1000 * k, static_cast<float>(k));
  bytes += message('R', std::string("\0\0", 2)) + sample('\0', 5500, 8);
  bytes += message('A', std::string("\0\0\0", 3) + "sensor_accel");
  for (int k = 5; k < 8; ++k) bytes += sample('\0', 1000 + 1000 * k, static_cast<float>(100 + k));
  write_bytes(folder.file("a.ulg"), bytes);
  const Recording read = read_recording(folder.file("a.ulg"), {}, {});
  EXPECT_EQ(names_of(read), (std::vector<std::string>{"gyro.x[rad/s]", "accelerometer.x[m/s^2]"}));
  EXPECT_EQ(read.channels.at(0).values, (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(read.channels.at(1).values, (std::vector<double>{105, 106, 107}));
  EXPECT_NE(said(read.findings, "messages_not_described").find("2 of them"), std::string::npos);
  expect_streams_the_same(folder.file("a.ulg"), {}, 2);
}

TEST(ULog, InstancesAreNamedInTheirOrder) {
  const ScratchFolder folder;
  std::string bytes = head + message('F', "sensor_gyro:uint64_t timestamp;float x;");
  bytes += message('A', std::string("\1\0\0", 3) + "sensor_gyro") + sample('\0', 1000, 10);  // instance 1 is first
  bytes += message('A', std::string("\0\1\0", 3) + "sensor_gyro") + sample('\1', 1000, 20);
  write_bytes(folder.file("a.ulg"), bytes + sample('\0', 2000, 11) + sample('\1', 2000, 21));
  const Recording both = read_recording(folder.file("a.ulg"), {.topics = {"sensor_gyro"}}, {});
  EXPECT_EQ(names_of(both), (std::vector<std::string>{"gyro.x[rad/s]", "gyro1.x[rad/s]"}));
  EXPECT_EQ(both.channels.at(0).values, (std::vector<double>{20, 21}));
  EXPECT_EQ(both.channels.at(1).values, (std::vector<double>{10, 11}));
}

TEST(ULog, DriversUpToVersion110CorrectedWhatTheyPublished) {
  const ScratchFolder folder;
  std::string bytes = head + message('F', "sensor_gyro:uint64_t timestamp;float x;int16_t x_raw;");
  bytes += message('A', std::string("\0\0\0", 3) + "sensor_gyro");
  for (const std::uint64_t time : {1000, 2000, 3000}) {
    std::string body("\0\0", 2);
    body.append(reinterpret_cast<const char*>(&time), 8);
    bytes += message('D', body + std::string(6, '\1'));
  }
  write_bytes(folder.file("a.ulg"), bytes);
  EXPECT_NE(said(read_recording(folder.file("a.ulg"), {}, {}).findings, "corrected_topic"), "");
}

TEST(ULog, AFormatWithTwoDescriptionsIsNotRead) {
  const ScratchFolder folder;
  std::string bytes = head;
  for (const char* name : {"sensor_gyro", "sensor_accel"})
    bytes += message('F', std::string(name) + ":uint64_t timestamp;float x;");
  bytes += message('A', std::string("\0\0\0", 3) + "sensor_gyro") + sample('\0', 1000, 1);
  bytes += message('A', std::string("\0\1\0", 3) + "sensor_accel") + sample('\1', 1000, 2);
  bytes += message('F', "sensor_accel:uint64_t timestamp;float x;") + sample('\1', 2000, 3);  // as before
  bytes += message('F', "sensor_gyro:uint64_t timestamp;int32_t x;") + sample('\0', 2000, 3);
  write_bytes(folder.file("a.ulg"), bytes);
  const Recording read = read_recording(folder.file("a.ulg"), {}, {});
  EXPECT_EQ(names_of(read), (std::vector<std::string>{"accelerometer.x[m/s^2]"}));
  EXPECT_EQ(read.channels.at(0).values, (std::vector<double>{2, 3}));
  EXPECT_NE(said(read.findings, "messages_not_described").find("sensor_gyro"), std::string::npos);
}

/// A position of id 1 at a time [us], with the date of the receiver [us].
std::string position(std::uint64_t time, std::uint64_t date) {
  std::string body("\1\0", 2);
  body.append(reinterpret_cast<const char*>(&time), 8);
  return message('D', body + std::string(4, '\1') + std::string(reinterpret_cast<const char*>(&date), 8));
}

TEST(ULog, TheDateOfTheReceiverIsThatOfTheLog) {
  constexpr std::uint64_t date = 1'700'000'000'000'000;
  const ScratchFolder folder;
  std::string bytes = head + message('F', "sensor_gyro:uint64_t timestamp;float x;");
  bytes += message('F', "sensor_gps:uint64_t timestamp;int32_t lat;uint64_t time_utc_usec;");
  bytes +=
      message('A', std::string("\0\0\0", 3) + "sensor_gyro") + message('A', std::string("\0\1\0", 3) + "sensor_gps");
  bytes += sample('\0', 5'000'000, 1) + position(6'000'000, 0) + sample('\0', 7'000'000, 2);  // 0: no fix yet
  write_bytes(folder.file("none.ulg"), bytes);
  EXPECT_FALSE(read_recording(folder.file("none.ulg"), {}, {}).meta.contains("clock_start"));
  write_bytes(folder.file("dated.ulg"), bytes + position(8'000'000, date) + position(9'000'000, 1));
  EXPECT_EQ(read_recording(folder.file("dated.ulg"), {}, {}).meta.at("clock_start"), "2023-11-14T22:13:17Z");
  for (const std::uint64_t wrong : {~std::uint64_t{0}, std::uint64_t{1} << 63, std::uint64_t{300'000'000'000'000}}) {
    write_bytes(folder.file("wrong.ulg"), bytes + position(8'000'000, wrong));
    EXPECT_FALSE(read_recording(folder.file("wrong.ulg"), {}, {}).meta.contains("clock_start")) << wrong;
  }
}

TEST(ULog, AShortTimestampIsRefusedByName) {
  const ScratchFolder folder;
  std::string bytes = head + message('F', "sensor_gyro:uint32_t timestamp;float x;");
  bytes += message('A', std::string("\0\0\0", 3) + "sensor_gyro") + message('D', std::string(10, '\1'));
  write_bytes(folder.file("a.ulg"), bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"sensor_gyro"}}, refusal_of(folder.file("a.ulg"))));
}

TEST(ULog, AnInfiniteSampleIsMissing) {
  const ScratchFolder folder;
  std::string bytes = head + message('F', "sensor_gyro:uint64_t timestamp;float x;");
  bytes += message('A', std::string("\0\0\0", 3) + "sensor_gyro");
  for (const float value : {1.0f, INFINITY, 2.0f}) {
    std::string body(14, '\0');
    std::memcpy(body.data() + 10, &value, 4);
    body[3] = static_cast<char>(bytes.size() / 100);
    bytes += message('D', body);
  }
  write_bytes(folder.file("a.ulg"), bytes);
  const Recording read = read_recording(folder.file("a.ulg"), {}, {});
  EXPECT_TRUE(std::isnan(read.channels.at(0).values.at(1)));
  EXPECT_NE(said(read.findings, "infinite_samples").find("one sample"), std::string::npos);
}

}  // namespace
}  // namespace tumble
