// The files of tests/reference/mat, whose samples follow from their number (SOURCE.md), and damaged ones.

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

#include "tumble/formats/testing/log_files.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::string reference(const std::string& name) { return TUMBLE_SOURCE_DIR "/tests/reference/mat/" + name; }

double value(double of_array, std::size_t k, double column) {
  return of_array + 0.001 * static_cast<double>(k + 1) * column;
}

ReadOptions units(std::initializer_list<const char*> names) {
  ReadOptions options;
  for (const char* name : names) options.units[name] = Unit::parse("1");
  return options;
}

Recording read(const std::string& name, const ReadOptions& options) {
  return read_recording(reference(name), options, {});
}

TEST(Mat, AllVersionsHoldTheSame) {
  for (const char* name : {"plain.mat", "packed.mat", "old.mat", "hdf5.mat"}) {
    ReadOptions options = units({"gyro", "acc", "temperature"});
    options.topics = {"gyro", "acc", "temperature"};
    const Recording log = read(name, options);
    ASSERT_EQ(log.channels.size(), 7u) << name;
    for (std::size_t k = 0; k < 60; ++k) {
      EXPECT_EQ(find_channel(log, "gyro.x")->values.at(k), value(1, k, 1)) << name;
      EXPECT_EQ(find_channel(log, "gyro.z")->values.at(k), value(1, k, 3)) << name;
      EXPECT_EQ(find_channel(log, "acc.y")->values.at(k), value(2, k, 2)) << name;
      EXPECT_EQ(find_channel(log, "temperature")->values.at(k), value(3, k, 1)) << name;
    }
    EXPECT_EQ(log.channels[0].timeline.rate, 200.0) << name;
    EXPECT_EQ(log.meta.at("note"), "unit 0117") << name;
    EXPECT_NE(said(log.findings, "topics_not_read").find("bias"), std::string::npos) << name;
  }
}

TEST(Mat, BlocksJoinToTheWhole) {
  for (const char* name : {"plain.mat", "packed.mat", "old.mat", "hdf5.mat"}) {
    ReadOptions options = units({"gyro", "acc", "temperature"});
    options.topics = {"gyro", "acc", "temperature"};
    expect_streams_the_same(reference(name), options, 7);
    // Seven vectors of 60, and what the file holds in addition to them.
    const auto memory = recording_memory(format_of(reference(name)), reference(name), options);
    EXPECT_GE(memory, 8u * 7 * 60) << name;
    EXPECT_LT(memory, 8u * 16 * 60) << name;
  }
}

std::string as_word(std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  return {reinterpret_cast<const char*>(&word), sizeof word};
}

/// A variable of version 4.
std::string level4(const std::string& name, const std::vector<double>& values) {
  return as_word(0) + as_word(values.size()) + as_word(1) + as_word(0) + as_word(name.size() + 1) + name + '\0' +
         std::string(reinterpret_cast<const char*>(values.data()), 8 * values.size());
}

TEST(Mat, DaysAreNotTakenForSeconds) {
  const ScratchFolder folder;
  std::vector<double> days, seconds, gyro;
  for (int k = 0; k < 100; ++k) {
    days.push_back(739'945.375 + k / 86400.0);  // datenum, one sample a second
    seconds.push_back(739'945.0 + k);           // since a start nine days ago
    gyro.push_back(k % 7);
  }
  ReadOptions options = units({"gyro"});
  write_bytes(folder.file("a.mat"), level4("time", days) + level4("gyro", gyro));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"time", "time"}, .pattern = "--set unit.{}=day"},
                      refusal_of(folder.file("a.mat"), options)));
  options.units["time"] = Unit::parse("day");
  const Recording read = read_recording(folder.file("a.mat"), options, {});
  // A day has 1e-10 d = 10 us at this distance from the year 0.
  EXPECT_NEAR(read.channels.at(0).time(99) - read.channels.at(0).time(0), 99.0, 2e-5);
  write_bytes(folder.file("b.mat"), level4("time", seconds) + level4("gyro", gyro));
  EXPECT_TRUE(refusal_of(folder.file("b.mat"), units({"gyro"})).empty());
}

TEST(Mat, UnixTimeInMillisecondsIsNotTakenForSeconds) {
  const ScratchFolder folder;
  std::vector<double> stamps, gyro;
  for (int k = 0; k < 100; ++k) {
    stamps.push_back(1'700'000'000'000.0 + 5.0 * k);
    gyro.push_back(k % 7);
  }
  ReadOptions options = units({"gyro"});
  write_bytes(folder.file("a.mat"), level4("timestamp", stamps) + level4("gyro", gyro));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"timestamp", "timestamp"}, .pattern = "--set unit.{}=ms"},
                      refusal_of(folder.file("a.mat"), options)));
  options.units["timestamp"] = Unit::parse("ms");
  EXPECT_NEAR(read_recording(folder.file("a.mat"), options, {}).channels.at(0).timeline.rate, 200.0, 1e-6);
  write_bytes(folder.file("b.mat"), level4("timestamp_ms", stamps) + level4("gyro", gyro));
  EXPECT_TRUE(refusal_of(folder.file("b.mat"), units({"gyro"})).empty());
}

/// An element of version 5.
std::string element(std::size_t type, std::string data) {
  const std::string head = as_word(type) + as_word(data.size());
  return head + data.append((8 - data.size() % 8) % 8, '\0');
}

/// The matrix element of a column of numbers.
std::string column5(const std::string& name, const std::vector<double>& values) {
  const std::string numbers(reinterpret_cast<const char*>(values.data()), 8 * values.size());
  return element(14, element(6, as_word(6) + as_word(0)) + element(5, as_word(values.size()) + as_word(1)) +
                         element(1, name) + element(9, numbers));
}

const std::string level5 = "MATLAB 5.0 MAT-file" + std::string(105, ' ') + std::string("\0\1IM", 4);

TEST(Mat, ObjectsOfMatlabAreNamedAndNotRead) {
  const ScratchFolder folder;
  // datetime: no dimensions; what MATLAB keeps of its objects is an array without a name behind the variables
  const std::string inside = element(14, element(6, as_word(13) + as_word(0)) + element(5, as_word(6) + as_word(1)) +
                                             element(1, "") + element(6, std::string(24, '\1')));
  const std::string when = element(14, element(6, as_word(17) + as_word(0)) + element(1, "when") + element(1, "MCOS") +
                                           element(1, "datetime") + inside);
  std::vector<double> numbers(200, 1.0);
  numbers.front() = 2.0;
  for (const bool last : {false, true}) {
    const std::string samples = column5("gyro", {1, 2, 3, 4}) + column5("fs", {200.0});
    write_bytes(folder.file("a.mat"), level5 + (last ? samples + when : when + samples) + column5("", numbers));
    const Recording log = read_recording(folder.file("a.mat"), units({"gyro"}), {});
    ASSERT_EQ(log.channels.size(), 1u);
    EXPECT_EQ(log.channels[0].values, (std::vector<double>{1, 2, 3, 4}));
    EXPECT_NE(said(log.findings, "variables_not_read").find("when"), std::string::npos);
  }
}

TEST(Mat, TheNearestClockCounts) {
  const ScratchFolder folder;
  // imu.gyro with imu.fs = 25 Hz beside it, and t of the same length, at 100 Hz, around the structure.
  const std::string imu =
      element(14, element(6, as_word(2) + as_word(0)) + element(5, as_word(1) + as_word(1)) + element(1, "imu") +
                      element(5, as_word(8)) + element(1, std::string("gyro\0\0\0\0fs\0\0\0\0\0\0", 16)) +
                      column5("", {1, 2, 3}) + column5("", {25}));
  write_bytes(folder.file("a.mat"), level5 + column5("t", {0, 0.01, 0.02}) + column5("acc", {4, 5, 6}) + imu);
  const Recording read = read_recording(folder.file("a.mat"), units({"acc", "imu.gyro"}), {});
  EXPECT_DOUBLE_EQ(find_channel(read, "acc")->timeline.rate, 100.0);
  EXPECT_DOUBLE_EQ(find_channel(read, "imu.gyro")->timeline.rate, 25.0);
}

TEST(Mat, TextIsUtf8WhereTheFileSaysSo) {
  const ScratchFolder folder;
  const std::string text = "Prüfling µ 陀螺\n";
  const std::string note = element(6, as_word(4) + as_word(0)) + element(5, as_word(1) + as_word(15)) +
                           element(1, "note") + element(16, text);
  write_bytes(folder.file("a.mat"), level5 + element(14, note) + column5("gyro", {1, 2, 3}));
  ReadOptions options = units({"gyro"});
  options.rate = 100.0;
  EXPECT_EQ(read_recording(folder.file("a.mat"), options, {}).meta.at("note"), "Prüfling µ 陀螺?");
}

TEST(Mat, ShortArraysAreNotReadUnasked) {
  const Recording log = read("plain.mat", units({"gyro", "acc", "temperature"}));
  EXPECT_EQ(log.channels.size(), 7u);
}

TEST(Mat, FieldsOfStructuresHaveTheirOwnTime) {
  ReadOptions options = units({"imu.gyro", "imu.raw"});
  options.topics = {"imu"};
  for (const char* name : {"structure.mat", "hdf5.mat"}) {
    const Recording log = read(name, options);
    ASSERT_EQ(log.channels.size(), 6u) << name;
    EXPECT_EQ(find_channel(log, "imu.gyro.y")->values.at(5), value(1, 5, 2));
    EXPECT_EQ(find_channel(log, "imu.raw.z")->values.at(9), static_cast<int>(100 * value(2, 9, 3))) << name;
    EXPECT_EQ(log.channels[0].timeline.rate, 200.0);
  }
}

TEST(Mat, ArraysOfStructuresAndANumberForTheRate) {
  ReadOptions options = units({"trial.1.gyro", "trial.2.gyro"});
  options.topics = {"trial"};
  const Recording log = read("structure.mat", options);
  ASSERT_EQ(log.channels.size(), 2u);
  EXPECT_EQ(log.channels[1].name, "trial.2.gyro");
  EXPECT_EQ(log.channels[1].values.at(3), value(6, 3, 1));
  EXPECT_EQ(log.channels[1].timeline.rate, 100.0);  // there is a time in imu, but not in trial
  EXPECT_NE(said(log.findings, "variables_not_read").find("wave"), std::string::npos);
}

TEST(Mat, ColumnsOfATableAreNamed) {
  ReadOptions options;
  options.columns = {"time[s]", "gyro.x[deg/s]", "-", "spare[1]"};
  const Recording log = read("table.mat", options);
  ASSERT_EQ(log.channels.size(), 2u);
  EXPECT_EQ(log.channels[0].unit.text(), "deg/s");
  EXPECT_EQ(log.channels[1].values.at(7), value(1, 7, 3));
  EXPECT_EQ(log.channels[1].timeline.rate, 200.0);
  options.columns.pop_back();
  EXPECT_TRUE(
      refuses(Error::Kind::bad_file, Asked{.values = {"4", "data", "3"}}, refusal_of(reference("table.mat"), options)));
}

TEST(Mat, WhatIsMissingIsSaidAtOnce) {
  const auto message = refusal_of(reference("table.mat"));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"data.1, data.2, data.3, data.4", "data"}}, message));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"data"}, .pattern = "no time"}, message));
}

TEST(Mat, CutAnywhereWholeVariablesRemain) {
  const ScratchFolder folder;
  ReadOptions options = units({"gyro", "acc", "temperature", "t"});
  options.rate = 200.0;
  for (const char* name : {"plain.mat", "packed.mat", "old.mat", "hdf5.mat"}) {
    const std::string bytes = read_text_file(reference(name));
    const Recording whole = read(name, units({"gyro", "acc", "temperature", "imu.gyro", "imu.raw"}));
    for (std::size_t size = 1; size < bytes.size(); size += 1 + bytes.size() / 300) {
      write_bytes(folder.file("a.mat"), std::string_view(bytes).substr(0, size));
      try {
        const Recording cut = read_recording(folder.file("a.mat"), options, {});
        for (const Channel& channel : cut.channels)
          EXPECT_EQ(channel.values, find_channel(whole, channel.name)->values);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind, Error::Kind::bad_file) << error.what();
      }
    }
  }
}

TEST(Mat, CellsOfVersion73AreFollowed) {
  ReadOptions options = units({"run.1", "run.2", "run.4.1", "trial.1.gyro", "trial.2.gyro"});
  const Recording read = read_recording(reference("cells.mat"), options, {});
  std::vector<std::string> names;
  for (const Channel& channel : read.channels) names.push_back(channel.name);
  EXPECT_EQ(names, (std::vector<std::string>{"run.1.x", "run.1.y", "run.1.z", "run.2.x", "run.2.y", "run.2.z",
                                             "run.4.1", "trial.1.gyro", "trial.2.gyro"}));
  for (std::size_t k = 0; k < 60; ++k) {
    const double n = 0.001 * static_cast<double>(k + 1);
    EXPECT_EQ(read.channels[4].values[k], 2 + n * 2);
    EXPECT_EQ(read.channels[6].values[k], 4 + n);
    EXPECT_EQ(read.channels[8].values[k], 6 + n);
  }
  EXPECT_EQ(read.channels[0].timeline.rate, 200.0);
  EXPECT_EQ(read.meta.at("run.3"), "unit 0117");
  EXPECT_NE(said(read.findings, "variables_not_read").find("table"), std::string::npos);
  expect_streams_the_same(reference("cells.mat"), options, 7);
}

/// A variable of version 5, packed.
std::string packed(const std::string& content) {
  std::string bytes(compressBound(content.size()), '\0');
  uLongf size = bytes.size();
  compress2(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(content.data()),
            content.size(), 9);
  bytes.resize(size);
  const std::uint32_t tag[2] = {15, static_cast<std::uint32_t>(size)};
  return std::string(reinterpret_cast<const char*>(tag), 8) + bytes;
}

std::string words(std::initializer_list<std::uint32_t> values) {
  return {reinterpret_cast<const char*>(std::data(values)), 4 * values.size()};
}

const std::string head5 = "MATLAB 5.0 MAT-file" + std::string(105, ' ') + std::string("\0\1IM", 4);

std::string variable(std::uint32_t rows, std::uint32_t columns, std::uint32_t type, std::uint32_t size) {
  return words({6, 8, 6, 0, 5, 8, rows, columns, 0x10001, 'x', type, size});
}

TEST(Mat, SizesThatLieAreRefused) {
  const ScratchFolder folder;
  const std::pair<std::uint32_t, std::uint32_t> extents[] = {
      {0xffffffff, 0xffffffff}, {0x80000000, 2}, {0x20000000, 1}, {4, 0x10000000}};
  for (const auto& [rows, columns] : extents)
    for (const std::uint32_t size : {0u, 16u, 0x40000000u, 0xfffffff8u}) {
      const std::string element = variable(rows, columns, 9, size);
      const std::string matrix =
          words({14, static_cast<std::uint32_t>(element.size() + 16)}) + element + std::string(16, '\1');
      for (const std::string& body : {matrix, packed(matrix)}) {
        write_bytes(folder.file("a.mat"), head5 + body);
        EXPECT_TRUE(
            refuses(Error::Kind::bad_file, Asked{.values = {folder.file("a.mat")}}, refusal_of(folder.file("a.mat"))));
      }
    }
}

TEST(Mat, WhatUnpacksToTooMuchIsRefused) {
  const ScratchFolder folder;
  const std::uint32_t count = 140000000;  // bytes that would take 1.1 GB as numbers, from 140 kB
  const std::string element = variable(count, 1, 2, count);
  write_bytes(folder.file("a.mat"), head5 + packed(words({14, static_cast<std::uint32_t>(element.size() + count)}) +
                                                   element + std::string(count, '\0')));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "more than a file of this size can hold"},
                      refusal_of(folder.file("a.mat"))));
}

TEST(Mat, PackedBytesThatHoldMoreThanTheirVariableAreRefused) {
  const ScratchFolder folder;
  const std::string element = variable(4, 1, 9, 32) + std::string(32, '\1');
  const std::string matrix = words({14, static_cast<std::uint32_t>(element.size())}) + element;
  const ReadOptions options{.rate = 100.0, .units = {{"x", Unit::parse("1")}}};
  write_bytes(folder.file("a.mat"), head5 + packed(matrix + std::string(8, '\0')));  // padding
  EXPECT_TRUE(refusal_of(folder.file("a.mat"), options).empty());
  write_bytes(folder.file("a.mat"), head5 + packed(matrix + std::string(5000, '\1')));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "hold more than the variable"},
                      refusal_of(folder.file("a.mat"), options)));
}

TEST(Mat, StructuresWithoutEndAreRefused) {
  const ScratchFolder folder;
  std::string inner;
  for (int depth = 0; depth < 40; ++depth) {
    const std::string element =
        words({6, 8, 2, 0, 5, 8, 1, 1, 0x10001, 'x', 0x40005, 4, 1, 4}) + std::string("a\0\0\0\0\0\0\0", 8);
    inner = words({14, static_cast<std::uint32_t>(element.size() + inner.size())}) + element + inner;
  }
  write_bytes(folder.file("a.mat"), head5 + inner);
  EXPECT_TRUE(
      refuses(Error::Kind::bad_file, Asked{.values = {folder.file("a.mat")}}, refusal_of(folder.file("a.mat"))));
}

}  // namespace
}  // namespace tumble
