// Recordings that are longer than a block of those in which they are sealed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/recorder_read.hpp"

namespace tumble {
namespace {

constexpr std::uint64_t fast_samples = 300000, lost_each = 1000, ratio = 10;
constexpr double fast_rate = 1000.0;  // Hz

/// Two streams of one unit: a rate and an increment at 1 kHz, of which some are lost, and a temperature at 100 Hz.
void record_long_run(const std::string& folder, Disk& disk, double declared) {
  RecorderOptions options;
  options.reserve_bytes = 1 << 16;
  options.commit_bytes = 1 << 22;
  Recorder recorder(folder, disk, options);
  const std::size_t link = recorder.add_link({.name = "tcp:10.0.0.7:9000"});
  const Unit rate = Unit::parse("rad/s"), kelvin = Unit::parse("K");
  const std::size_t fast = recorder.add_stream({"unit", "", {{"x", rate}, {"y", rate, true}}, declared, link});
  const std::size_t slow = recorder.add_stream({"unit", "", {{"t", kelvin}}, declared / ratio, link});
  for (std::uint64_t k = 0; k < fast_samples; ++k) {
    const double number = static_cast<double>(k), time = (number + 1.0) / fast_rate;
    const double pair[] = {std::sin(number), number}, air[] = {300.0 + number};
    if (k % lost_each != lost_each / 2) recorder.sample(fast, {time, {}, k, pair});
    if (k % ratio == 0) recorder.sample(slow, {time, {}, k / ratio, air});
    if (k % 100000 == 0) recorder.flush();
  }
  recorder.close(fast_samples / fast_rate, "complete");
}

void expect_the_same(const Channel& a, const Channel& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  EXPECT_TRUE(std::ranges::equal(a.values, b.values, same)) << a.name;
  EXPECT_EQ(a.timeline.start, b.timeline.start) << a.name;
  EXPECT_EQ(a.timeline.rate, b.timeline.rate) << a.name;
}

TEST(Seal, ALongRecordingIsThatOfTheStore) {
  for (const double declared : {fast_rate, 0.0}) {  // the even clock is known before the samples, or after them
    const ScratchFolder folder;
    Disk disk;
    record_long_run(folder.path, disk, declared);
    const auto stored = read_store(folder.path);
    const auto sealed = seal(folder.path, disk);
    ASSERT_EQ(sealed.size(), 1u);
    const Recording back = read_recording(sealed[0].path, {}, {});
    ASSERT_EQ(back.channels.size(), 3u);
    for (const Channel& channel : back.channels)
      expect_the_same(channel, *find_channel(stored[0].recording, channel.name));
    const Channel& x = *find_channel(back, "x");
    EXPECT_EQ(x.values.size(), fast_samples);
    EXPECT_EQ(std::ranges::count_if(x.values, [](double value) { return std::isnan(value); }),
              static_cast<std::ptrdiff_t>(fast_samples / lost_each));
    EXPECT_EQ(x.values[271828], std::sin(271828.0));
    EXPECT_NEAR(find_channel(back, "y")->values[271828], 271828.0 * fast_rate, 1e-6 * 271828.0 * fast_rate);
    EXPECT_EQ(find_channel(back, "t")->values[27182], 300.0 + 271820.0);
    EXPECT_EQ(seal(folder.path, disk)[0].sha256, sealed[0].sha256);
  }
}

TEST(Seal, InfiniteSamplesAreMissingAndSaid) {
  const ScratchFolder folder;
  Disk disk;
  {
    Recorder recorder(folder.path, disk, {});
    const std::size_t link = recorder.add_link({.name = "tcp:10.0.0.7:9000"});
    const std::size_t stream = recorder.add_stream(
        {"unit", "", {{"x", Unit::parse("deg/h")}, {"y", Unit::parse("rad/s"), true}}, fast_rate, link});
    for (std::uint64_t k = 0; k < 1000; ++k) {
      // 1e306 rad/s is finite, and infinite in the unit of the file
      const double pair[] = {k == 500 ? HUGE_VAL : k == 501 ? 1e306 : 1.0, k == 700 ? -HUGE_VAL : 2.0};
      recorder.sample(stream, {(static_cast<double>(k) + 1.0) / fast_rate, {}, k, pair});
    }
    recorder.close(1.0, "complete");
  }
  const auto sealed = seal(folder.path, disk);
  ASSERT_EQ(sealed.size(), 1u);
  const Recording back = read_recording(sealed[0].path, {}, {});
  const auto missing = [&](const char* name) {
    return std::ranges::count_if(find_channel(back, name)->values, [](double v) { return std::isnan(v); });
  };
  EXPECT_EQ(find_channel(back, "x")->values.size(), 1000u);
  EXPECT_EQ(missing("x"), 2);
  EXPECT_EQ(missing("y"), 1);
  EXPECT_NEAR(find_channel(back, "y")->values[699], 2.0 * fast_rate, 1e-9 * fast_rate);
  std::map<std::string, std::size_t> said;
  for (const Finding& finding : sealed[0].findings)
    if (finding.code == "infinite_samples") said[finding.where] = finding.occurrences.count;
  EXPECT_EQ(said, (std::map<std::string, std::size_t>{{"x", 2}, {"y", 1}}));
}

}  // namespace
}  // namespace tumble
