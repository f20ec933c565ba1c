// Frames without sync word, which are found by their counter.
#include <gtest/gtest.h>

#include <random>

#include "tumble/units/error.hpp"
#include "tumble/wire/frames.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace {

/// Frames of the KVH DSP gyro whose rate [step] is `rate(i)`.
template <class Rate>
std::string kvh_dsp(std::uint64_t begin, std::uint64_t count, Rate rate) {
  const FrameCodec codec = codec_of(find_instrument("kvh_dsp"));
  std::string bytes;
  for (std::uint64_t i = begin; i < begin + count; ++i) {
    const double value = static_cast<double>(rate(i)) * codec.frames[0].fields[0].factor;
    bytes += encode_frame(codec, {0, {value}, {1}, i % 4});
  }
  return bytes;
}

std::string still(std::uint64_t begin, std::uint64_t count) {
  return kvh_dsp(begin, count, [](std::uint64_t) { return 17; });
}

struct CountedFrames {
  std::vector<std::uint64_t> sequence, offsets;
  FrameCounts counts;
};

CountedFrames counted_frames(std::string_view bytes, std::size_t piece) {
  const FrameCodec codec = codec_of(find_instrument("kvh_dsp"));
  CountedFrames result;
  FrameStream stream(codec);
  const auto sink = [&](const StreamFrame& frame) {
    result.sequence.push_back(frame.sequence);
    result.offsets.push_back(frame.offset);
  };
  for (std::size_t at = 0; at < bytes.size(); at += piece) stream.feed(bytes.substr(at, piece), sink);
  stream.finish(sink);
  result.counts = stream.counts();
  return result;
}

TEST(CountedFrames, AreFoundAtAnyOffset) {
  for (std::size_t offset = 0; offset < 6; ++offset)
    for (const std::size_t piece : {1u, 5u, 100000u}) {
      const CountedFrames all = counted_frames(still(0, 50).substr(offset), piece);
      ASSERT_EQ(all.sequence.size(), offset == 0 ? 50u : 49u);
      EXPECT_EQ(all.offsets[0], (6 - offset) % 6);
      EXPECT_EQ(all.counts.skipped_bytes, (6 - offset) % 6);
      EXPECT_EQ(all.counts.cut, 0u);
    }
}

TEST(CountedFrames, AreFoundAgainAfterGarbage) {
  std::mt19937_64 random(5);
  for (const std::size_t piece : {1u, 5u, 6u, 7u, 100u, 100000u}) {
    std::string noise;
    for (int i = 0; i < 100; ++i) noise += static_cast<char>(random() % 256);
    const std::string bytes = still(0, 30) + noise + still(31, 30);
    const CountedFrames all = counted_frames(bytes, piece);
    for (const std::uint64_t offset : all.offsets) EXPECT_TRUE(offset + 6 <= 180 || offset >= 280) << offset;
    EXPECT_GE(all.sequence.size(), 54u) << "up to three on both sides of the garbage are not used";
    EXPECT_EQ(all.counts.skipped_bytes, 280u + 6u * 30u - 6u * all.sequence.size());
    EXPECT_EQ(all.counts.skipped.count, 1u);
  }
}

TEST(CountedFrames, ThatWaitedForOthersAtTheEndAreNotDamaged) {
  const CountedFrames all = counted_frames(still(0, 50) + std::string("\x90\0\0", 3), 7);
  EXPECT_EQ(all.sequence.size(), 50u);
  EXPECT_EQ(all.counts.damaged.count, 0u);
  EXPECT_EQ(all.counts.skipped_bytes + all.counts.cut, 3u);
}

// The first frame that is used behind the garbage is the one before it once more, by its two bits.
TEST(CountedFrames, BehindGarbageAreNotTakenForRepeatedOnes) {
  const std::string garbage(6 * 11, '\0');
  const CountedFrames all = counted_frames(still(0, 30) + garbage + still(41, 30), 64);
  EXPECT_EQ(all.counts.repeated.count, 0u);
  EXPECT_EQ(all.sequence.back(), 70u);
}

TEST(CountedFrames, ShowOneThatIsLostOrSpoiled) {
  const CountedFrames lost = counted_frames(still(0, 30) + still(31, 30), 7);
  EXPECT_EQ(lost.sequence.size(), 60u);
  EXPECT_EQ(lost.sequence.back(), 60u);
  EXPECT_EQ(lost.counts.lost, 1u);
  EXPECT_EQ(lost.counts.skipped_bytes, 0u);
  std::string bytes = still(0, 60);
  bytes[6 * 30] ^= '\x40';
  const CountedFrames spoiled = counted_frames(bytes, 7);
  EXPECT_EQ(spoiled.sequence.size(), 59u);
  EXPECT_EQ(spoiled.sequence.back(), 59u);
  EXPECT_EQ(spoiled.counts.skipped_bytes, 6u);
}

TEST(CountedFrames, AreNotSeenInAConstantStreamOrInNoise) {
  EXPECT_EQ(counted_frames(std::string(6000, '\x90'), 64).sequence.size(), 0u);
  EXPECT_EQ(counted_frames(std::string(6000, '\0'), 64).sequence.size(), 0u);
  EXPECT_EQ(counted_frames(still(0, 9), 64).sequence.size(), 0u) << "fewer than ten do not prove it";
  EXPECT_EQ(counted_frames(still(0, 10), 64).sequence.size(), 10u);
  std::mt19937_64 random(6);
  std::string noise;
  for (int i = 0; i < 20000; ++i) noise += static_cast<char>(random() % 256);
  // At 20000 places with probability 4^-9: 0.08 expected, and none with this seed.
  EXPECT_EQ(counted_frames(noise, 64).sequence.size(), 0u);
}

TEST(CountedFrames, NeedACounterAndAFixedLength) {
  const auto problems = [](const std::string& frame) {
    try {
      read_frames(
          "title = \"a\"\ncertainty = \"computed\"\n[[frame]]\nchannel = {name = \"a\", at = 1, type = \"u8\"}\n" +
              frame,
          "a.toml");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::pair<const char*, const char*> cases[] = {
      {"length = 6\nsync = {by = \"counter\"}", "need counter"},
      {"length = 6\nsync = {by = \"clock\"}\ncounter = {at = 0}", "by: \"counter\" is expected"},
      {"length = 6\nsync = {by = \"counter\", frames = 1}\ncounter = {at = 0}", "frames: 4 to 1000"},
      {"length = {at = 1}\nsync = {by = \"counter\"}\ncounter = {at = 0}", "fixed length"},
      {"length = 6\nsync = {by = \"counter\"}\ncounter = {at = 0, step = \"any\"}", "need counter"},
      {"length = 6\nsync = {by = \"counter\"}\ncounter = {at = 0}\n[[frame]]\nsync = \"AA\"\nlength = 2\n",
       "is the only [[frame]]"},
  };
  for (const auto& [frame, part] : cases)
    EXPECT_NE(problems(frame).find(part), std::string::npos) << frame << "\n" << problems(frame);
}

}  // namespace
}  // namespace tumble
