// The logs of tests/reference/dataflash, whose values follow from the number of the message (SOURCE.md), and damaged
// ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tumble/core/instant.hpp"
#include "tumble/formats/testing/log_files.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::dataflash_test {
namespace {

std::string reference(const char* name) { return std::string(TUMBLE_SOURCE_DIR "/tests/reference/dataflash/") + name; }

Recording read(const char* name, const ReadOptions& options = {}) {
  return read_recording(reference(name), options, {});
}

TEST(DataFlash, ReadsTheFirstImu) {
  const Recording log = read("copter.bin");
  ASSERT_EQ(log.channels.size(), 7u);
  EXPECT_EQ(log.channels[0].name, "gyro.x");
  EXPECT_EQ(log.channels[3].name, "accelerometer.x");
  EXPECT_EQ(log.channels[3].unit.text(), "m/s^2");
  EXPECT_EQ(log.channels[6].name, "temperature");
  for (std::size_t k = 0; k < 30; ++k) {
    const auto i = static_cast<double>(k);
    EXPECT_EQ(log.channels[0].values.at(k), static_cast<float>(0.001 * i));
    EXPECT_EQ(log.channels[3].values.at(k), static_cast<float>(1 + 0.25 * i));
    EXPECT_EQ(log.channels[6].values.at(k), 30 + 0.5 * i + 273.15);
    EXPECT_EQ(log.channels[0].time(k), (5e6 + 2500 * i + static_cast<double>(k * 53 % 300)) / 1e6);
  }
  EXPECT_EQ(log.instrument, "ArduCopter V4.5.1 (abcdef01)");
  EXPECT_EQ(log.meta.at("INS_ACCSCAL_Y"), "1.5");
  EXPECT_FALSE(log.meta.contains("ATC_RAT_RLL_P"));
  EXPECT_NE(said(log.findings, "corrected_by_parameters").find("INS_GYROFFS_X, INS_ACCSCAL_Y:"), std::string::npos);
  EXPECT_NE(said(log.findings, "topics_not_read").find("IMU:1, ATT;"), std::string::npos);
  EXPECT_EQ(log.findings.size(), 2u);
}

/// Descriptions of IMU and GPS, and their messages.
std::string fmt(char id, const std::string& name, const std::string& types, const std::string& labels, int length) {
  const auto padded = [](std::string text, std::size_t size) { return text.append(size - text.size(), '\0'); };
  return std::string("\xa3\x95\x80") + id + static_cast<char>(length) + padded(name, 4) + padded(types, 16) +
         padded(labels, 64);
}

template <class T>
std::string bytes_of(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string with_gps(std::uint8_t status) {
  std::string log = fmt('\x80', "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89) +
                    fmt(10, "IMU", "Qf", "TimeUS,GyrX", 15) + fmt(11, "GPS", "QBIH", "TimeUS,Status,GMS,GWk", 18);
  const auto imu = [&](std::uint64_t at) { log += "\xa3\x95\n" + bytes_of(at) + bytes_of(1.0f); };
  const auto gps = [&](std::uint64_t at, std::uint8_t fix, std::uint32_t ms, std::uint16_t week) {
    log += "\xa3\x95\x0b" + bytes_of(at) + bytes_of(fix) + bytes_of(ms) + bytes_of(week);
  };
  for (std::uint64_t k = 0; k < 10; ++k) imu(2'000'000 + 1'000'000 * k);
  gps(12'000'000, 1, 0, 0);
  // 2017-01-01T00:00:00 UTC is second 18 of week 1930 of GPS: 18 leap seconds
  gps(12'500'000, status, 18'000, 1930);
  return log;
}

TEST(DataFlash, InstancesAreNamedInTheirOrder) {
  const auto padded = [](std::string text) { return text.append(16 - text.size(), '\0'); };
  std::string log = fmt('\x80', "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89) +
                    fmt(12, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 44) +
                    fmt(10, "IMU", "QBfc", "TimeUS,I,GyrX,GyrY", 18) + "\xa3\x95\x0c" + bytes_of(std::uint64_t{0}) +
                    "\x0a" + padded("s#EE") + padded("F-0?");
  for (std::uint64_t k = 0; k < 6; ++k)  // instance 1 comes first
    log += "\xa3\x95\n" + bytes_of(1'000'000 + 1000 * k) + bytes_of(static_cast<std::uint8_t>(1 - k % 2)) +
           bytes_of(static_cast<float>(k)) + bytes_of(std::int16_t{150});
  const ScratchFolder folder;
  write_bytes(folder.file("a.bin"), log);
  const Recording read = read_recording(folder.file("a.bin"), {.topics = {"IMU"}}, {});
  ASSERT_EQ(read.channels.size(), 4u);
  EXPECT_EQ(read.channels[0].name, "gyro.x");
  EXPECT_EQ(read.channels[0].values, (std::vector<double>{1, 3, 5}));
  EXPECT_EQ(read.channels[2].name, "gyro1.x");
  EXPECT_EQ(read.channels[2].values, (std::vector<double>{0, 2, 4}));
  EXPECT_NE(said(read.findings, "corrected_topic"), "");  // nothing says that the corrections are neutral
  EXPECT_DOUBLE_EQ(read.channels[1].values.at(0), 1.5);   // of type c, in hundredths: the multiplier "?" says nothing
}

TEST(DataFlash, AGpsReceiverSaysWhenTheLogBegan) {
  const ScratchFolder folder;
  write_bytes(folder.file("a.bin"), with_gps(3));
  const Recording log = read_recording(folder.file("a.bin"), {}, {});
  EXPECT_EQ(log.meta.at("clock_start"), "2016-12-31T23:59:49.5Z");  // 10.5 s before the fix
  Extent extent;
  extent.add(log);
  EXPECT_EQ(test_times(log.meta, extent).begun, "2016-12-31T23:59:49Z");
  EXPECT_EQ(test_times(log.meta, extent).ended, "2016-12-31T23:59:58Z");
  write_bytes(folder.file("b.bin"), with_gps(1));  // the receiver has no fix
  EXPECT_FALSE(read_recording(folder.file("b.bin"), {}, {}).meta.contains("clock_start"));
}

TEST(DataFlash, AnInstanceIsPickedByName) {
  EXPECT_EQ(read("copter.bin", {.topics = {"IMU:1"}}).channels[3].values.at(2), 2.5);
  EXPECT_EQ(read("copter.bin", {.topics = {"IMU:1"}}).channels[3].name, "accelerometer.x");
  EXPECT_EQ(read("copter.bin", {.topics = {"IMU"}}).channels[10].name, "accelerometer1.x");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"IMU:2"}, .part = "IMU:0, IMU:1, ATT"},
                      refusal_of(reference("copter.bin"), {.topics = {"IMU:2"}})));
}

TEST(DataFlash, TheMultiplierReplacesTheFactorOfTheType) {
  for (const char* name : {"copter.bin", "old.bin"}) {  // with and without FMTU
    const Recording log = read(name, {.topics = {"ATT"}});
    const bool described = std::string(name) == "copter.bin";
    EXPECT_EQ(log.channels.at(1).name, "ATT.Pitch");
    EXPECT_EQ(log.channels.at(1).unit.text(), described ? "deg" : "1");
    EXPECT_NEAR(log.channels[1].values.at(2), -50 * 6 * 0.01 * (described ? degree : 1.0), 1e-15);
    EXPECT_NEAR(log.channels.at(3).values.at(2), 7 * 6 * (described ? 0.001 : 0.01), 1e-15) << name;
    EXPECT_NEAR(log.channels.at(4).values.at(2), (-353632610 + 6) * 1e-7, 1e-13);
  }
}

TEST(DataFlash, OldLogsHaveTheUnitsOfTheNames) {
  const Recording log = read("old.bin");
  EXPECT_EQ(log.channels.at(5).unit.text(), "m/s^2");
  EXPECT_EQ(log.channels[5].values.size(), 12u);
  EXPECT_EQ(said(log.findings, "log_damaged") + said(log.findings, "log_cut_off"), "");  // erased memory is no damage
}

TEST(DataFlash, RawSamplesComeFirst) {
  const Recording log = read("raw.bin");
  ASSERT_EQ(log.channels.size(), 6u);
  EXPECT_EQ(log.channels[0].timeline.rate, 1000.0);
  EXPECT_EQ(log.channels[2].values.at(7), -3.5);
  EXPECT_NEAR(log.channels[3].time(7), 6.00702, 1e-12);
}

TEST(DataFlash, MessagesWithoutADescriptionAreSkipped) {
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "without FMT"}, refusal_of(reference("no_fmt.bin"))));
  const Recording log = read("no_fmt.bin", {.topics = {"ATT"}});
  EXPECT_EQ(log.channels.at(0).values.size(), 4u);
  EXPECT_NE(said(log.findings, "messages_not_described").find("24"), std::string::npos);
}

TEST(DataFlash, BlocksHoldWhatReadingGives) {
  expect_streams_the_same(reference("copter.bin"), {}, 7);
  expect_streams_the_same(reference("copter.bin"), {.topics = {"IMU", "ATT"}}, 7);
  expect_streams_the_same(reference("raw.bin"), {}, 7);
}

TEST(DataFlash, CutAnywhereTheSamplesBeforeRemain) {
  const std::string bytes = read_text_file(reference("copter.bin"));
  expect_prefixes(bytes.substr(0, bytes.size() - 2500));
  const ScratchFolder folder;
  write_bytes(folder.file("a.bin"), bytes.substr(0, bytes.size() - 20));
  EXPECT_NE(said(read_recording(folder.file("a.bin"), {}, {}).findings, "log_cut_off"), "");
}

TEST(DataFlash, AfterDamageReadingGoesOn) {
  const ScratchFolder folder;
  const std::string good = read_text_file(reference("copter.bin"));
  const Recording whole = read("copter.bin");
  for (std::size_t back = 2200; back > 1000; back -= 31) {
    std::string bytes = good;
    bytes.erase(bytes.size() - back, 23);
    write_bytes(folder.file("a.bin"), bytes);
    const Recording log = read_recording(folder.file("a.bin"), {}, {});
    EXPECT_GE(log.channels[0].values.size(), 28u) << back;
    EXPECT_NE(said(log.findings, "log_damaged") + said(log.findings, "messages_not_described"), "") << back;
    for (const double value : log.channels[3].values)  // no sample from a message that lacks bytes
      EXPECT_NE(std::ranges::find(whole.channels[3].values, value), whole.channels[3].values.end()) << back;
  }
}

TEST(DataFlash, ADescriptionThatContradictsAnotherIsNotUsed) {
  const ScratchFolder folder;
  std::string bytes = read_text_file(reference("copter.bin"));
  const auto imu = bytes.find("QBffffffIIfBBHH");
  std::string second = bytes.substr(imu - 9, 89);
  second[9] = 'q';
  bytes.insert(bytes.find("\xa3\x95\x8c"), second);
  write_bytes(folder.file("a.bin"), bytes);
  EXPECT_TRUE(
      refuses(Error::Kind::bad_file, Asked{.pattern = "no messages of a gyro"}, refusal_of(folder.file("a.bin"))));
}

/// Messages of IMU around a FMTU and a MULT.
std::string with_units(const std::string& units, const std::string& multipliers, double second) {
  const auto padded = [](std::string text) { return text.append(16 - text.size(), '\0'); };
  std::string log = fmt('\x80', "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89) +
                    fmt(12, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 44) +
                    fmt(13, "MULT", "Qbd", "TimeUS,Id,Mult", 20) + fmt(10, "IMU", "Qfh", "TimeUS,GyrX,AccX", 17) +
                    fmt(14, "ATT", "Qf", "TimeUS,Roll", 15);
  const auto mult = [&](double value) { log += "\xa3\x95\x0d" + bytes_of(std::uint64_t{0}) + "A" + bytes_of(value); };
  const auto fmtu = [&](const std::string& unit, const std::string& factor) {
    log += "\xa3\x95\x0c" + bytes_of(std::uint64_t{0}) + "\x0a" + padded(unit) + padded(factor);
  };
  mult(0.5);
  fmtu("sEo", "F?A");
  for (std::uint64_t k = 0; k < 6; ++k) {
    if (k == 3) mult(second);
    if (k == 3) fmtu(units, multipliers);
    log += "\xa3\x95\n" + bytes_of(1'000'000 + 1000 * k) + bytes_of(1.0f) + bytes_of(std::int16_t{10});
    log += "\xa3\x95\x0e" + bytes_of(1'000'000 + 1000 * k) + bytes_of(2.0f);
  }
  return log;
}

TEST(DataFlash, AMultiplierThatChangesMakesMessagesUnreadable) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& log) {
    write_bytes(folder.file("a.bin"), log);
    return refusal_of(folder.file("a.bin"));
  };
  EXPECT_TRUE(refused(with_units("sEo", "F?A", 0.5)).empty());  // said again
  EXPECT_EQ(read_recording(folder.file("a.bin"), {}, {}).channels.at(1).values.at(5), 5.0);
  for (const auto& log : {with_units("sEo", "F?A", 0.25), with_units("sEo", "F??", 0.5), with_units("s?o", "F?A", 0.5)})
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "no messages of a gyro"}, refused(log)));
  const Recording other = read_recording(folder.file("a.bin"), {.topics = {"ATT"}}, {});
  EXPECT_EQ(other.channels.at(0).values.size(), 6u);
  EXPECT_NE(said(other.findings, "messages_not_described").find("IMU"), std::string::npos);
}

}  // namespace
}  // namespace tumble::dataflash_test
