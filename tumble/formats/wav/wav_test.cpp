// The files of tests/reference/wav, whose samples follow from their number (SOURCE.md), and damaged ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tumble/formats/testing/log_files.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::wav_test {
namespace {

std::string reference(const std::string& name) { return TUMBLE_SOURCE_DIR "/tests/reference/wav/" + name; }

double count(std::size_t k, std::size_t channel) {
  return static_cast<double>(100 * k + channel) * (k % 2 == 0 ? 1.0 : -1.0);
}

ReadOptions in_g() {
  ReadOptions options;
  for (const char* name : {"channel1", "channel2", "channel3"}) options.units[name] = Unit::parse("g");
  return options;
}

TEST(Wav, IntegersAreCounts) {
  const std::pair<const char*, double> files[] = {
      {"counts16.wav", 1.0}, {"counts24.wav", 256.0}, {"counts32.wav", 65536.0}, {"large.wav", 1.0}};
  for (const auto& [name, scale] : files) {
    const Recording read = read_recording(reference(name), {}, {});
    ASSERT_EQ(read.channels.size(), 3u) << name;
    EXPECT_TRUE(read.findings.empty()) << name;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(read.channels[c].name, "channel" + std::to_string(c + 1));
      EXPECT_EQ(read.channels[c].kind, QuantityKind::count);
      EXPECT_EQ(read.channels[c].timeline.rate, 12800.0);
      ASSERT_EQ(read.channels[c].values.size(), 50u);
      for (std::size_t k = 0; k < 50; ++k) EXPECT_EQ(read.channels[c].values[k], scale * count(k, c)) << name;
    }
  }
  EXPECT_EQ(read_recording(reference("large.wav"), {}, {}).meta.at("INAM"), "shaker");
}

TEST(Wav, OneIsFullScaleInAGivenUnit) {
  for (const char* name : {"counts16.wav", "counts24.wav", "counts32.wav", "float32.wav", "float64.wav"}) {
    const Recording read = read_recording(reference(name), in_g(), {});
    EXPECT_EQ(read.channels[1].kind, QuantityKind::specific_force);
    EXPECT_NEAR(read.channels[1].values[7], count(7, 1) / 32768.0 * standard_gravity, 1e-15) << name;
    EXPECT_EQ(said(read.findings, "full_scale_is_one").empty(), std::string(name).starts_with("float")) << name;
  }
}

TEST(Wav, FloatingPointSamplesNeedAUnit) {
  const auto message = refusal_of(reference("float32.wav"));
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"channel1, channel2, channel3", "channel1"}}, message));
}

TEST(Wav, BlocksHoldWhatReadingGives) {
  expect_streams_the_same(reference("counts24.wav"), {}, 7);
  expect_streams_the_same(reference("float64.wav"), in_g(), 1);
}

/// The same file with the highest digits first.
std::string reversed(std::string bytes, std::size_t width) {
  const auto turn = [&](std::size_t at, std::size_t size) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
  };
  bytes.replace(0, 4, "RIFX");
  const std::size_t data = bytes.find("data") + 8;
  for (const std::size_t at : {std::size_t{4}, std::size_t{16}, std::size_t{24}, std::size_t{28}, data - 4})
    turn(at, 4);
  for (const std::size_t at : {20u, 22u, 32u, 34u}) turn(at, 2);
  if (data > 44) turn(36, 2), turn(42, 4), turn(46, 4);  // no more of the format, and the chunk 'fact'
  for (std::size_t at = data; at + width <= bytes.size(); at += width) turn(at, width);
  return bytes;
}

TEST(Wav, HighestDigitsFirstAreReadAsWell) {
  const ScratchFolder folder;
  const std::pair<const char*, std::size_t> files[] = {{"counts16.wav", 2}, {"counts32.wav", 4}, {"float64.wav", 8}};
  for (const auto& [name, width] : files) {
    write_bytes(folder.file("a.wav"), reversed(read_text_file(reference(name)), width));
    const Recording usual = read_recording(reference(name), in_g(), {});
    const Recording other = read_recording(folder.file("a.wav"), in_g(), {});
    ASSERT_EQ(other.channels.size(), usual.channels.size()) << name;
    EXPECT_EQ(other.channels[2].timeline.rate, 12800.0);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(other.channels[c].values, usual.channels[c].values) << name;
  }
}

TEST(Wav, CutAnywhereTheSamplesBeforeRemain) {
  expect_prefixes(read_text_file(reference("counts16.wav")));
  expect_prefixes(read_text_file(reference("large.wav")));
  const ScratchFolder folder;
  write_bytes(folder.file("a.wav"), read_text_file(reference("counts16.wav")).substr(0, 203));
  const Recording read = read_recording(folder.file("a.wav"), {}, {});
  EXPECT_NE(said(read.findings, "wav_size"), "");
  EXPECT_NE(said(read.findings, "log_cut_off"), "");
}

TEST(Wav, ARecorderThatWasSwitchedOffLeavesASizeOfZero) {
  const ScratchFolder folder;
  std::string bytes = read_text_file(reference("counts16.wav"));
  bytes.replace(bytes.find("data") + 4, 4, 4, '\0');
  write_bytes(folder.file("a.wav"), bytes);
  EXPECT_EQ(read_recording(folder.file("a.wav"), {}, {}).channels[2].values.size(), 50u);
}

TEST(Wav, CompressedSamplesAreRefused) {
  const ScratchFolder folder;
  std::string bytes = read_text_file(reference("counts16.wav"));
  bytes[20] = 2;  // ADPCM
  write_bytes(folder.file("a.wav"), bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"2", "16", "2"}}, refusal_of(folder.file("a.wav"))));
}

}  // namespace
}  // namespace tumble::wav_test
