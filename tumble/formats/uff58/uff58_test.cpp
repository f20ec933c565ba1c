#include <gtest/gtest.h>

#include "tumble/formats/testing/reference_texts.hpp"

namespace tumble {
namespace {

/// Dataset 58 with three samples, single precision, even; columns as in the description of the format.
std::string dataset(const std::string& unit, const std::string& samples, const char* kind = "   1") {
  const std::string blank(80, ' ');
  const auto put = [](std::string line, std::size_t at, const std::string& text) {
    return line.replace(at, text.size(), text);
  };
  std::string text = "    -1\n    58\nNONE\nNONE\nNONE\nNONE\nNONE\n";
  text += put(put(blank, 1, kind), 41, "         7   3") + "\n";
  text += "         2         3         1  0.00000E+00  3.33333E-04  0.00000E+00\n";
  text += put(put(blank, 0, "        17    0    0    0"), 47, "s") + "\n";
  text += put(put(blank, 0, "        12    0    0    0"), 47, unit) + "\n" + blank + "\n" + blank + "\n";
  return text + samples + "\n    -1\n";
}

TEST(Uff58, FilesOfPyuffReadBackEqual) {
  const auto recording = read_recording(reference_text("time.uff"), {}, {});
  ASSERT_EQ(recording.channels.size(), 2u);
  for (const Channel& channel : recording.channels) {
    EXPECT_EQ(channel.timeline.start, 0.0);
    EXPECT_EQ(channel.timeline.rate, 200.0) << channel.name;
  }
  EXPECT_EQ(recording.channels[0].name, "ax");
  EXPECT_EQ(recording.channels[0].values, ramp(1, 50, Unit::parse("m/s^2")));
  EXPECT_EQ(recording.channels[1].values, ramp(3, 50, Unit::parse("g")));
  EXPECT_NE(said(recording.findings, "functions_not_read").find("1 function"), std::string::npos);
}

// Numbers of Fortran touch where they are negative; the step has six digits and means 3000 Hz.
TEST(Uff58, NumbersThatTouch) {
  const ScratchFolder folder;
  write_file_atomically(folder.file("a.uff"), dataset("m/s^2", " 1.50000E+00-2.50000D+00-3.00000E-01"));
  const auto recording = read_recording(folder.file("a.uff"), {}, {});
  EXPECT_EQ(recording.channels[0].values, (std::vector{1.5, -2.5, -0.3}));
  EXPECT_EQ(recording.channels[0].name, "node7.Z");
  EXPECT_DOUBLE_EQ(recording.channels[0].timeline.rate, 3000.0);
}

TEST(Uff58, UnitsComeFromTheLabelOrDataset164OrTheUser) {
  const std::string samples = " 1.0 2.0 3.0";
  const auto refused = refusal_of(dataset("", samples), "a.uff");
  EXPECT_NE(refused.find("channels without a unit: 'node7.Z'"), std::string::npos) << refused;
  ReadOptions options;
  options.units = {{"node7.Z", Unit::parse("g")}};
  EXPECT_EQ(refusal_of(dataset("", samples), "a.uff", options), "");
  const std::string si = "    -1\n   164\n         1SI                          2\n    -1\n";
  EXPECT_EQ(refusal_of(si + dataset("", samples), "a.uff"), "");
}

TEST(Uff58, WhatIsNoTimeResponseIsSaid) {
  EXPECT_NE(refusal_of(dataset("g", " 1 2 3", "   4"), "a.uff").find("no time response"), std::string::npos);
  EXPECT_NE(refusal_of("    -1\n    58b     1     1\n", "a.uff").find("export it as ASCII"), std::string::npos);
  EXPECT_NE(refusal_of(dataset("g", " 1 2"), "a.uff").find("2 numbers instead of 3"), std::string::npos);
  EXPECT_NE(refusal_of(dataset("g", " 1 2 3 4"), "a.uff").find("more numbers"), std::string::npos);
  EXPECT_NE(refusal_of(dataset("g", " 1 two 3"), "a.uff").find("does not consist of numbers"), std::string::npos);
}

TEST(Uff58, BlocksJoinToTheWhole) { expect_streams_the_same(reference_text("time.uff"), {}, 7); }

// Abscissae in ms, each before its sample: even, and not.
TEST(Uff58, AbscissaBeforeEachSample) {
  const auto with_stamps = [](std::string text, const std::string& samples) {
    const auto put = [&](std::string_view what, std::string_view by) {
      text.replace(text.find(what), what.size(), by);
    };
    put("         3         1  0.0", "         3         0  0.0");
    put("s   ", "ms  ");
    put("samples", samples);
    return text;
  };
  const ScratchFolder folder;
  write_file_atomically(folder.file("a.uff"), with_stamps(dataset("g", "samples"), " 1.0 5.0 3.0 6.0\n 5.0 7.0"));
  const auto even = read_recording(folder.file("a.uff"), {}, {});
  EXPECT_EQ(even.channels[0].timeline.rate, 500.0);
  EXPECT_EQ(even.channels[0].timeline.start, 1e-3);
  EXPECT_EQ(even.channels[0].values[2], Unit::parse("g").to_si(7.0));
  write_file_atomically(folder.file("b.uff"), with_stamps(dataset("g", "samples"), " 1.0 5.0 3.0 6.0\n 15.0 7.0"));
  EXPECT_DOUBLE_EQ(read_recording(folder.file("b.uff"), {}, {}).channels[0].time(2), 0.015);
  expect_streams_the_same(folder.file("b.uff"), {}, 1);
}

TEST(Uff58, CutAnywhereItIsReadOrRefused) { EXPECT_LT(beginnings_read(reference_text("time.uff"), 101), 70u); }

}  // namespace
}  // namespace tumble
