// Text tables that were read wrongly without a word: time since the start of a device, units, rows and characters that
// looked like something else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/formats/testing/text_table.hpp"

namespace tumble {
namespace {

struct CsvDevices : TextTable {};

TEST_F(CsvDevices, TheTimeSinceTheStartOfADeviceIsNoUnixTime) {
  const std::pair<const char*, const char*> files[] = {
      {"1234567890,1\n1234571890,2\n1234575890,3\n", "us"},                    // 20 minutes, 250 Hz
      {"1234567890123456,1\n1234567895123456,2\n1234567900123456,3\n", "ns"},  // 14 days, 200 Hz
      {"1234567890123,1\n1234572890123,2\n1234577890123,3\n", "ns"}};          // 20 minutes, 200 Hz
  for (const auto& [rows, unit] : files)
    EXPECT_TRUE(
        refuses_with(std::string("timestamp,a[1]\n") + rows,
                     {{.values = {"timestamp", "timestamp"}}, {.part = std::string("--set unit.timestamp=") + unit}}));
  EXPECT_TRUE(refuses("Time;a[1]\n45981,375000000;1\n45981,375011574;2\n", {.part = "--set unit.Time=day"}));
  // A pause does not change it, and neither does a slow log whose unit is said.
  const std::string paused = "1700000000000000,1\n1700000000005000,2\n1700000300000000,3\n1700000300005000,4\n";
  EXPECT_EQ(read("timestamp,a[1]\n" + paused).channels.at(0).time(2), 300.0);
  EXPECT_EQ(read("timestamp[us],a[1]\n1700000000000000,1\n1700000060000000,2\n").meta.at("clock_start"),
            "2023-11-14T22:13:20Z");
  // Slow logs in Unix time: every ten minutes in s, every second in ms.
  EXPECT_EQ(read("timestamp,a[1]\n1700000000,1\n1700000600,2\n").channels.at(0).time(1), 600.0);
  EXPECT_EQ(read("timestamp,a[1]\n1700000000000,1\n1700000001000,2\n").channels.at(0).time(1), 1.0);
}

TEST_F(CsvDevices, AUnitInWordsIsTheLongest) {
  const auto recording = read("time[s],gyro x / deg / s,gyro y in deg / s,加速度（m/s^2）\n0,1,2,3\n1,2,3,4\n");
  ASSERT_EQ(recording.channels.size(), 3u);
  EXPECT_EQ(recording.channels[0].name, "gyro x");
  EXPECT_EQ(recording.channels[1].name, "gyro y");
  EXPECT_EQ(recording.channels[2].name, "加速度");
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(recording.channels[c].kind, QuantityKind::angular_rate);
    EXPECT_EQ(recording.channels[c].values.at(0), Unit::parse("deg/s").to_si(1.0 + static_cast<double>(c)));
  }
  EXPECT_EQ(recording.channels[2].kind, QuantityKind::specific_force);
}

TEST_F(CsvDevices, MetresPerSecondSquaredAreNoMilliseconds) {
  const auto recording = read("time[s],a[ms-2],b (ms^-2),w[rads-1]\n0,1,2,3\n1,2,3,4\n");
  EXPECT_EQ(recording.channels.at(0).kind, QuantityKind::specific_force);
  EXPECT_EQ(recording.channels.at(1).values.at(1), 3.0);
  EXPECT_EQ(recording.channels.at(1).kind, QuantityKind::specific_force);
  EXPECT_EQ(recording.channels.at(2).kind, QuantityKind::angular_rate);
}

TEST_F(CsvDevices, ASampleOfWordsBehindTheUnitsIsNotSkipped) {
  const std::string table = "t;gx;gy\ns;deg/s;deg/s\n0,00;OL;OL\n0,01;1,5;2,5\n0,02;1,6;2,6\n0,03;1,7;2,7\n";
  EXPECT_TRUE(refuses(table, {.values = {"OL"}, .channel = "gx", .line = 3}));
  options.missing = "OL";
  const auto recording = read(table);
  ASSERT_EQ(recording.channels.at(0).values.size(), 4u);
  EXPECT_TRUE(std::isnan(recording.channels[0].values[0]));
  EXPECT_EQ(recording.channels[0].time(0), 0.0);
  options.missing.clear();
  const auto places = read("t;gx;gy\ns;deg/s;deg/s\n-;left;right\n0,00;1;2\n0,01;1,5;2,5\n0,02;1,6;2,6\n");
  EXPECT_EQ(places.channels.at(0).values.size(), 3u);
  expect_holds(said(places.findings, "lines_before_samples_skipped"), {"-;left;right"});
}

TEST_F(CsvDevices, AUnitOfTheHeaderThatIsUnknownCanBeGiven) {
  const std::string table = "time[s],a[G]\n0,1\n1,2\n";
  EXPECT_TRUE(refuses_with(table, {{.values = {"G"}, .channel = "a"}, {.part = "--set unit.a="}}));
  options.units = {{"a", Unit::parse("g")}};
  EXPECT_EQ(read(table).channels.at(0).values.at(1), Unit::parse("g").to_si(2.0));
}

TEST_F(CsvDevices, LinesOfWordsBeforeTheTableDoNotChooseItsSeparator) {
  for (const char separator : {';', ',', '\t'}) {
    std::string table =
        "Time;gyro [deg/s];a [g]\n20-Nov-2026 09:00:00.0 AM;1;2\n20-Nov-2026 09:00:00.5 AM;2;3\n"
        "20-Nov-2026 09:00:01.0 AM;3;4\n";
    std::ranges::replace(table, ';', separator);
    const auto recording = read("Logger Model 7\nOperator: A. B\n" + table);
    ASSERT_EQ(recording.channels.size(), 2u);
    EXPECT_EQ(recording.channels[0].values.at(2), Unit::parse("deg/s").to_si(3.0));
    EXPECT_EQ(recording.channels[0].timeline.rate, 2.0);
  }
  const auto blanks = read("a[g] b[g] t[s]\n0,1 0,2 0\n0,3 0,4 1\n");
  EXPECT_EQ(blanks.channels.at(1).values.at(1), Unit::parse("g").to_si(0.4));
}

TEST_F(CsvDevices, ARowOfTabsIsARowOfMissingSamples) {
  options.rate = 10.0;
  const auto recording = read("a[g]\tb[g]\t\n1\t2\t\n\t\t\n3\t4\t\n\t\t\n");
  ASSERT_EQ(recording.channels.at(0).values.size(), 3u);
  EXPECT_TRUE(std::isnan(recording.channels[0].values[1]));
  EXPECT_TRUE(std::isnan(recording.channels[1].values[1]));
  EXPECT_EQ(recording.channels[1].values[2], Unit::parse("g").to_si(4.0));
}

TEST_F(CsvDevices, CharactersOfFourBytesAreChinese) {
  // GB 18030: 陀螺[°/s], a[m/s²]; the superscript takes four bytes.
  const auto recording =
      read("time[s],\xCD\xD3\xC2\xDD[\xA1\xE3/s],a[m/s\x81\x30\x85\x35],b[m/s\x81\x30\x85\x35]\n0,1,2,3\n1,2,3,4\n");
  ASSERT_EQ(recording.channels.size(), 3u);
  EXPECT_EQ(recording.channels[0].name, "陀螺");
  EXPECT_EQ(recording.channels[1].kind, QuantityKind::specific_force);
}

TEST_F(CsvDevices, ANameThatWouldNotBeReadBackIsNotWritten) {
  auto recording = read("time[s],a[V]\n0,1\n1,2\n");
  for (const char* name : {"time", "a ", " a"}) {
    recording.channels[0].name = name;
    EXPECT_TRUE(tumble::refuses(Error::Kind::bad_input, Asked{.values = {name}, .pattern = "CSV header"}, [&] {
      write_recording(recording, folder.file("b.csv"));
    })) << name;
  }
}

}  // namespace
}  // namespace tumble
