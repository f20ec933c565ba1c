#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tumble/formats/testing/reference_texts.hpp"
#include "tumble/units/testing/asserts.hpp"

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
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"'node7.Z'"}}, refused));
  ReadOptions options;
  options.units = {{"node7.Z", Unit::parse("g")}};
  EXPECT_TRUE(refusal_of(dataset("", samples), "a.uff", options).empty());
  const std::string si = "    -1\n   164\n         1SI                          2\n    -1\n";
  EXPECT_TRUE(refusal_of(si + dataset("", samples), "a.uff").empty());
}

TEST(Uff58, WhatIsNoTimeResponseIsSaid) {
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "no time response"},
                      refusal_of(dataset("g", " 1 2 3", "   4"), "a.uff")));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"2", "3"}}, refusal_of(dataset("g", " 1 2"), "a.uff")));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"3"}, .pattern = "more numbers"},
                      refusal_of(dataset("g", " 1 2 3 4"), "a.uff")));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "1 two 3", .pattern = "numbers"},
                      refusal_of(dataset("g", " 1 two 3"), "a.uff")));
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

/// Numbers as bytes of one type and order.
template <class T>
std::string as_bytes(const std::vector<double>& numbers, bool reversed) {
  std::string bytes;
  for (const double number : numbers) {
    const auto value = static_cast<T>(number);
    char one[sizeof value];
    std::memcpy(one, &value, sizeof value);
    if (reversed) std::reverse(one, one + sizeof one);
    bytes.append(one, sizeof one);
  }
  return bytes;
}

/// The dataset of three samples above, binary. Given: bytes; ordinate: 2 or 4; even: 1, or 0 with abscissae.
std::string binary_dataset(const std::string& bytes, bool reversed, const char* ordinate, const char* even,
                           const char* format = "2", const char* end = "\n    -1\n") {
  std::string text = dataset("m/s^2", "samples");
  const auto put = [&](std::string_view what, const std::string& by) {
    text.replace(text.find(what), what.size(), by);
  };
  put("    58\n", std::string("    58b     ") + (reversed ? "2" : "1") + "     " + format + "          11" +
                      fmt::format("{:12}", bytes.size()) + "     0     0           0           0\n");
  put("         2         3         1", std::string("         ") + ordinate + "         3         " + even);
  put("samples\n    -1\n", bytes + end);
  return text;
}

TEST(Uff58, BinaryDatasetsOfBothOrders) {
  const ScratchFolder folder;
  const std::vector<double> samples{1.5, -2.5, 10.0};  // 10 is a line end in its last byte, if it is cut there
  for (const bool reversed : {false, true})
    for (const char* end : {"\n    -1\n", "    -1\n"}) {
      const auto single = binary_dataset(as_bytes<float>(samples, reversed), reversed, "2", "1", "2", end);
      write_bytes(folder.file("a.uff"), single + dataset("m/s^2", " 1.0 2.0 3.0"));
      const auto recording = read_recording(folder.file("a.uff"), {}, {});
      ASSERT_EQ(recording.channels.size(), 2u);
      EXPECT_EQ(recording.channels[0].values, samples);
      EXPECT_DOUBLE_EQ(recording.channels[0].timeline.rate, 3000.0);
      EXPECT_EQ(recording.channels[1].values, (std::vector<double>{1, 2, 3}));
      write_bytes(folder.file("a.uff"),
                  binary_dataset(as_bytes<double>(samples, reversed), reversed, "4", "1", "2", end));
      EXPECT_EQ(read_recording(folder.file("a.uff"), {}, {}).channels.at(0).values, samples);
    }
}

TEST(Uff58, BinaryDatasetsWithAbscissae) {
  const ScratchFolder folder;
  const auto expect_uneven = [&](const std::string& bytes, const char* ordinate) {
    write_bytes(folder.file("a.uff"), binary_dataset(bytes, false, ordinate, "0"));
    const auto recording = read_recording(folder.file("a.uff"), {}, {});
    EXPECT_EQ(recording.channels.at(0).values, (std::vector<double>{5, 6, 7}));
    EXPECT_EQ(recording.channels[0].time(2), 1.5);
    expect_streams_the_same(folder.file("a.uff"), {}, 1);
  };
  const std::vector<double> pairs{0.0, 5.0, 1.0, 6.0, 1.5, 7.0};
  expect_uneven(as_bytes<float>(pairs, false), "2");
  expect_uneven(as_bytes<double>(pairs, false), "4");
  std::string mixed;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    mixed += i % 2 == 0 ? as_bytes<float>({pairs[i]}, false) : as_bytes<double>({pairs[i]}, false);
  expect_uneven(mixed, "4");
}

TEST(Uff58, ABinaryDatasetThatIsWrongIsSaid) {
  const std::string bytes = as_bytes<float>({1, 2, 3}, false);
  const auto refused = [](const std::string& text) { return refusal_of(text, "a.uff"); };
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"1"}, .pattern = "58b"},
                      refused(binary_dataset(bytes, false, "2", "1", "1"))));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"16", "3"}},
                      refused(binary_dataset(bytes + "abcd", false, "2", "1"))));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "first line of a binary dataset"},
                      refused("    -1\n    58b     1     2\n")));
  const std::string whole = binary_dataset(bytes, false, "2", "1");
  for (std::size_t size = 20; size + 3 < whole.size(); size += 3)
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.part = "a.uff"}, refused(whole.substr(0, size)))) << size;
  const ScratchFolder folder;
  write_bytes(folder.file("a.uff"), binary_dataset(as_bytes<float>({1, INFINITY, 3}, false), false, "2", "1"));
  const auto recording = read_recording(folder.file("a.uff"), {}, {});
  EXPECT_TRUE(std::isnan(recording.channels.at(0).values[1]));
  EXPECT_NE(said(recording.findings, "infinite_samples"), "");
}

TEST(Uff58, CutAnywhereItIsReadOrRefused) { EXPECT_LT(beginnings_read(reference_text("time.uff"), 101), 70u); }

}  // namespace
}  // namespace tumble
