#include <gtest/gtest.h>

#include "tumble/formats/testing/reference_texts.hpp"

namespace tumble {
namespace {

TEST(SensorLogger, ReadsTheSensorsThatWereNotCorrected) {
  const auto recording = read_recording(reference_text("sensor_logger.zip"), {}, {});
  ASSERT_EQ(recording.channels.size(), 6u);
  const Channel* gyro = find_channel(recording, "GyroscopeUncalibrated.x");
  const Channel* up = find_channel(recording, "TotalAcceleration.z");
  const Channel* right = find_channel(recording, "TotalAcceleration.x");
  ASSERT_TRUE(gyro && up && right);
  EXPECT_EQ(gyro->values, ramp(1, 50, Unit::parse("rad/s")));  // the columns are z, y, x
  EXPECT_EQ(right->values, ramp(0, 50, Unit::parse("m/s^2")));
  EXPECT_EQ(up->values[7], 9.75);
  EXPECT_EQ(up->timeline.rate, 100.0);
  EXPECT_EQ(up->timeline.start, 0.0);
  EXPECT_DOUBLE_EQ(gyro->timeline.start, 0.0025);  // both on one clock
  EXPECT_EQ(recording.meta.at("platform"), "android");
  EXPECT_EQ(recording.meta.at("clock_start"), "2023-11-14T22:13:20Z");
  const auto others = said(recording.findings, "sensors_not_read");
  EXPECT_NE(others.find("Accelerometer (without gravity)"), std::string::npos) << others;
}

TEST(SensorLogger, BlocksJoinToTheWhole) {
  expect_streams_the_same(reference_text("sensor_logger.zip"), {}, 7);
  expect_streams_the_same(reference_text("sensor_logger.zip"), {.only = {"TotalAcceleration.z"}}, 7);
}

TEST(SensorLogger, AnotherSensorMayBePicked) {
  ReadOptions options;
  options.topics = {"Accelerometer"};
  const auto recording = read_recording(reference_text("sensor_logger.zip"), options, {});
  ASSERT_EQ(recording.channels.size(), 3u);
  EXPECT_EQ(recording.channels[0].name, "Accelerometer.x");
  EXPECT_EQ(recording.channels[0].values[0], 0.125);
  options.topics = {"Gyroscop"};
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"Gyroscop", "Gyroscope"}},
                      refusal_of(read_text_file(reference_text("sensor_logger.zip")), "a.zip", options)));
}

TEST(SensorLogger, ASensorWithoutSamplesIsLeftOut) {
  const ScratchFolder folder;
  write_file_atomically(folder.file("Metadata.csv"), "platform,standardisation\nandroid,false\n");
  write_file_atomically(folder.file("GyroscopeUncalibrated.csv"), "time,seconds_elapsed,z,y,x\n");
  EXPECT_TRUE(
      refuses(Error::Kind::bad_file, Asked{.values = {"GyroscopeUncalibrated"}}, refusal_of(folder.path.string())));
  for (const char* name : {"Gyroscope.csv", "TotalAcceleration.csv"})
    write_file_atomically(folder.file(name),
                          "time,seconds_elapsed,z,y,x\n1700000000000000000,0,1,2,3\n1700000000010000000,0.01,1,2,3\n");
  const auto recording = read_recording(folder.path.string(), {}, {});
  ASSERT_EQ(recording.channels.size(), 6u);
  EXPECT_EQ(recording.channels[0].name, "Gyroscope.x");
  EXPECT_NE(said(recording.findings, "sensors_empty").find("GyroscopeUncalibrated"), std::string::npos);
}

TEST(SensorLogger, AFolderIsReadToo) {
  const ScratchFolder folder;
  write_file_atomically(folder.file("Metadata.csv"), "platform,standardisation\nandroid,false\n");
  write_file_atomically(folder.file("TotalAcceleration.csv"),
                        "time,seconds_elapsed,z,y,x\n1700000000000000000,0,1,2,3\n1700000000010000000,0.01,1,2,3\n");
  const auto recording = read_recording(folder.path.string(), {}, {});
  ASSERT_EQ(recording.channels.size(), 3u);
  EXPECT_EQ(recording.channels[0].values[0], 3.0);
  EXPECT_EQ(sha256_of(recording.origin).size(), 64u);
}

// CROSSPLATFORM.md of the app: on its back a phone with iOS gives -1 g along z.
TEST(SensorLogger, AccelerationsOfIosAreTurned) {
  const std::string rows =
      "time,seconds_elapsed,z,y,x\n1700000000000000000,0,-1,2,3\n1700000000010000000,0.01,-1,2,3\n";
  for (const char* metadata : {"platform,standardisation\nios,false\n", "platform\nios\n"}) {
    const ScratchFolder folder;
    write_file_atomically(folder.file("Metadata.csv"), metadata);
    for (const char* name : {"AccelerometerUncalibrated.csv", "Accelerometer.csv", "Gyroscope.csv"})
      write_file_atomically(folder.file(name), rows);
    const auto recording = read_recording(folder.path.string(), {}, {});
    EXPECT_EQ(find_channel(recording, "AccelerometerUncalibrated.z")->values[0], Unit::parse("g").to_si(1.0));
    EXPECT_EQ(find_channel(recording, "Gyroscope.z")->values[0], -1.0);
    EXPECT_NE(said(recording.findings, "accelerations_of_ios"), "");
    const auto without_gravity = read_recording(folder.path.string(), {.topics = {"Accelerometer"}}, {});
    EXPECT_EQ(find_channel(without_gravity, "Accelerometer.z")->values[0], 1.0);  // in m/s^2 on both platforms
    write_file_atomically(folder.file("Metadata.csv"), "platform,standardisation\nios,true\n");
    const auto alike = read_recording(folder.path.string(), {}, {});
    EXPECT_EQ(find_channel(alike, "AccelerometerUncalibrated.z")->values[0], -1.0);
    EXPECT_EQ(said(alike.findings, "accelerations_of_ios"), "");
  }
}

}  // namespace
}  // namespace tumble
