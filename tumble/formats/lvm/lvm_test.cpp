#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tumble/formats/testing/reference_texts.hpp"

namespace tumble {
namespace {

void expect_ramps(const Recording& recording, std::size_t count) {
  ASSERT_EQ(recording.channels.size(), 2u);
  const Channel &ax = recording.channels[0], &gyro = recording.channels[1];
  EXPECT_EQ(ax.name, "ax");
  EXPECT_EQ(ax.unit.text(), "g");
  EXPECT_EQ(gyro.unit.text(), "deg/s");
  EXPECT_EQ(ax.values, ramp(1, count, ax.unit));
  EXPECT_EQ(gyro.values, ramp(2, count, gyro.unit));
  EXPECT_EQ(ax.timeline.start, 0.0);
}

TEST(Lvm, OneColumnOfTimes) {
  const auto recording = read_recording(reference_text("one_x.lvm"), {}, {});
  expect_ramps(recording, 25);
  EXPECT_EQ(recording.channels[0].timeline.rate, 100.0);
  EXPECT_EQ(recording.meta.at("Operator"), "lab");
}

TEST(Lvm, DecimalComma) {
  const auto recording = read_recording(reference_text("comma.lvm"), {}, {});
  expect_ramps(recording, 25);
  EXPECT_EQ(recording.channels[0].timeline.rate, 100.0);
  EXPECT_EQ(recording.meta.at("clock_start"), "2026-11-20T09:00:00");
}

// Each segment counts from its own begin, 1 s after the one before; it holds 0.25 s.
TEST(Lvm, SegmentsFollowByTheirDates) {
  const auto recording = read_recording(reference_text("two_segments.lvm"), {}, {});
  expect_ramps(recording, 50);
  EXPECT_DOUBLE_EQ(recording.channels[0].time(24), 0.24);
  EXPECT_DOUBLE_EQ(recording.channels[0].time(25), 1.0);
  EXPECT_NE(said(recording.findings, "segments_by_date"), "");
}

TEST(Lvm, AChannelWithoutUnitIsAskedFor) {
  std::string text = read_text_file(reference_text("one_x.lvm"));
  text.replace(text.find("Y_Unit_Label\tg\tdeg/s"), 20, "Y_Unit_Label\t\tdeg/s");
  const auto refused = refusal_of(text, "a.lvm");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"ax"}}, refused));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "--set 'unit.ax="}, refused));
  ReadOptions options;
  options.units = {{"ax", Unit::parse("m/s^2")}};
  EXPECT_TRUE(refusal_of(text, "a.lvm", options).empty());
}

TEST(Lvm, ADamagedCellIsNamed) {
  std::string text = read_text_file(reference_text("one_x.lvm"));
  text.replace(text.find("1.250000"), 8, "1.25x000");
  const auto refused = refusal_of(text, "a.lvm");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"1.25x000"}, .line = 26}, refused));
}

std::string with(std::string text, const std::string& what, const std::string& by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

TEST(Lvm, ANameThatStandsTwiceIsNumberedInEverySegment) {
  const std::string text = with(read_text_file(reference_text("two_segments.lvm")), "\tgyro\t", "\tax\t");
  const ScratchFolder folder;
  write_file_atomically(folder.file("a.lvm"), text);
  const auto recording = read_recording(folder.file("a.lvm"), {}, {});
  ASSERT_EQ(recording.channels.size(), 2u);
  EXPECT_EQ(recording.channels[1].name, "ax_2");
  EXPECT_EQ(recording.channels[1].values, ramp(2, 50, Unit::parse("deg/s")));
}

TEST(Lvm, AUnitThatChangesAndASpectrumAreRefused) {
  const std::string text = read_text_file(reference_text("two_segments.lvm"));
  std::string other = text;
  other.replace(other.rfind("Y_Unit_Label\tg"), 14, "Y_Unit_Label\tm/s^2");
  const auto changed = refusal_of(other, "a.lvm");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"ax", "m/s^2", "g"}}, changed));
  ASSERT_NE(text.find("X_Dimension\tTime"), std::string::npos);
  const auto spectrum = refusal_of(with(text, "X_Dimension\tTime", "X_Dimension\tFrequency"), "a.lvm");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"Frequency"}}, spectrum));
}

TEST(Lvm, AnUnknownUnitIsAskedFor) {
  const auto refused = refusal_of(
      with(read_text_file(reference_text("one_x.lvm")), "Y_Unit_Label\tg\t", "Y_Unit_Label\tbogus\t"), "a.lvm");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "bogus"}, refused));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "--set 'unit.ax="}, refused));
}

std::string measurement(const char* x_columns, const std::string& rows) {
  const std::string end = "***End_of_Header***\t\n";
  return std::string("LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t") + x_columns + "\n" +
         end + "\t\nChannels\t2\t\nY_Unit_Label\tg\tg\t\nX0\t0\t0\t\nDelta_X\t7.8125E-5\t7.8125E-5\t\n" + end +
         (x_columns == std::string("No") ? "" : "X_Value") + "\tax\tay\tComment\n" + rows;
}

Recording read_text(const std::string& text) {
  const ScratchFolder folder;
  write_file_atomically(folder.file("a.lvm"), text);
  return read_recording(folder.file("a.lvm"), {}, {});
}

TEST(Lvm, RoundedTimesOfAnEvenClockAreEven) {
  std::string rows;
  for (int k = 0; k < 1000; ++k) rows += fmt::format("{:.6f}\t{}\t0\n", k / 12800.0, k % 7);
  const auto recording = read_text(measurement("One", rows));
  EXPECT_EQ(recording.channels.at(0).timeline.stamps, nullptr);
  EXPECT_EQ(recording.channels.at(0).timeline.rate, 12800.0);
}

TEST(Lvm, ARowOfMissingSamplesTakesItsTime) {
  const auto recording = read_text(measurement("No", "\t1\t2\n\t\t\n\t3\t4\n\t5\t6\n"));
  ASSERT_EQ(recording.channels.at(0).values.size(), 3u);
  EXPECT_DOUBLE_EQ(recording.channels[0].time(1), 2 * 7.8125e-5);
  EXPECT_DOUBLE_EQ(recording.channels[1].time(2), 3 * 7.8125e-5);
}

TEST(Lvm, BlocksJoinToTheWhole) {
  for (const char* name : {"one_x.lvm", "two_segments.lvm"}) expect_streams_the_same(reference_text(name), {}, 7);
}

TEST(Lvm, CutAnywhereItIsReadOrRefused) {
  for (const char* name : {"one_x.lvm", "comma.lvm", "two_segments.lvm"})
    EXPECT_GT(beginnings_read(reference_text(name), 7), 20u) << name;
  const std::string whole = read_text_file(reference_text("one_x.lvm"));
  const auto refused = refusal_of(whole.substr(0, 100), "a.lvm");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "cut off"}, refused));
}

}  // namespace
}  // namespace tumble
