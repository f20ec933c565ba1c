// Frames that a network delivers in another order than they were sent, twice, or not at all.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tumble/wire/frames.hpp"

namespace tumble {
namespace {

using Random = std::mt19937_64;

/// A frame whose channel is the true number of the sample, and whose counter has so many bits.
FrameCodec codec_with_counter(int bits) {
  const std::string type = "u" + std::to_string(bits);
  std::string counted(static_cast<std::size_t>(bits) / 8, '\0');
  std::string hex = "AA 55";
  for (std::size_t i = 0; i < counted.size(); ++i) hex += " 00";
  const int at = 2 + bits / 8;
  hex += " 00 00 00 00 FF";
  return read_frames(
      "title = \"counted\"\ncertainty = \"computed\"\n[[frame]]\nname = \"data\"\nsync = \"AA 55\"\nlength = " +
          std::to_string(at + 5) + "\ncheck = {kind = \"sum\", over = [0, -1], at = -1}\ncounter = {at = 2, type = \"" +
          type + "\"}\nchannel = [{name = \"a\", at = " + std::to_string(at) +
          ", type = \"u32\", scale = \"1 rad/s\"}]\n[[vector]]\nmade_by_hand = true\nhex = \"" + hex +
          "\"\ncounter = 0\nvalues = {a = \"0 rad/s\"}\n",
      "counted.toml");
}

struct SentFrame {
  std::uint64_t number = 0, counter = 0;
};

std::string bytes_of(const FrameCodec& codec, const SentFrame& frame) {
  return encode_frame(codec, {0, {static_cast<double>(frame.number)}, {1}, frame.counter});
}

struct ReceivedFrames {
  std::vector<std::uint64_t> numbers, sequence, restarts, complete;
  FrameCounts counts;
};

ReceivedFrames received(const FrameCodec& codec, const std::vector<SentFrame>& sent, Random* pieces = nullptr) {
  std::string bytes;
  for (const SentFrame& frame : sent) bytes += bytes_of(codec, frame);
  ReceivedFrames result;
  FrameStream stream(codec);
  const auto sink = [&](const StreamFrame& frame) {
    result.numbers.push_back(static_cast<std::uint64_t>(frame.content.values[0] + 0.5));
    result.sequence.push_back(frame.sequence);
    result.restarts.push_back(frame.restarts);
    result.complete.push_back(frame.complete);
  };
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t count = pieces ? 1 + (*pieces)() % 60 : bytes.size();
    stream.feed(std::string_view(bytes).substr(at, count), sink);
    at += count;
  }
  stream.finish(sink);
  result.counts = stream.counts();
  return result;
}

/// What a network has done to a stream.
struct Delivery {
  std::vector<SentFrame> frames;
  std::set<std::uint64_t> lost;
  std::vector<std::uint64_t> restarts;  ///< numbers of the first frames behind them
  std::size_t repeated = 0;
};

/// 3000 frames of a counter that begins anywhere, except where a restart would look like a loss. Pairs, blocks, losses,
/// copies and, where `restarts`, a counter that begins again; each 40 frames from the next, so that none of them hides
/// another.
Delivery delivered(std::uint64_t modulus, bool restarts, Random& random) {
  Delivery all;
  std::uint64_t number = 0, counter = random() % std::min<std::uint64_t>(modulus, 50000);
  const auto next = [&] { return SentFrame{number++, std::exchange(counter, (counter + 1) % modulus)}; };
  const auto several = [&](std::uint64_t most) {
    std::vector<SentFrame> block;
    for (std::uint64_t i = 1 + random() % most; i > 0; --i) block.push_back(next());
    return block;
  };
  const auto put = [&](const std::vector<SentFrame>& block) {
    all.frames.insert(all.frames.end(), block.begin(), block.end());
  };
  while (number < 3000) {
    for (int i = 0; i < 40; ++i) all.frames.push_back(next());
    const auto first = several(8), second = several(8);
    switch (random() % (restarts ? 5 : 4)) {
      case 0:  // a block overtakes another
        put(second), put(first);
        break;
      case 1:  // shuffled
        put(first), put(second);
        std::shuffle(all.frames.end() - static_cast<std::ptrdiff_t>(second.size()), all.frames.end(), random);
        break;
      case 2:  // lost
        for (const SentFrame& frame : first) all.lost.insert(frame.number);
        put(second);
        break;
      case 3:  // twice, the copies up to 8 frames later
        put(first), put(second), put(first);
        if (first.size() + second.size() > 16)
          all.frames.resize(all.frames.size() - first.size());
        else
          all.repeated += first.size();
        break;
      default:
        put(first), put(second);
        counter = random() % 50;
        all.restarts.push_back(number);
    }
  }
  for (int i = 0; i < 40; ++i) all.frames.push_back(next());
  return all;
}

/// The number of a sample is that of the frames sent before it, exactly: of a counter of any width, over its wraps, and
/// whatever the order of arrival.
void expect_exact(int bits, bool restarts, std::uint64_t seed) {
  SCOPED_TRACE(std::to_string(bits) + " bits, seed " + std::to_string(seed));
  Random random(seed);
  const FrameCodec codec = codec_with_counter(bits);
  const Delivery sent = delivered(std::uint64_t{1} << bits, restarts, random);
  const ReceivedFrames got = received(codec, sent.frames, &random);
  ASSERT_TRUE(std::ranges::is_sorted(got.numbers));
  EXPECT_EQ(got.sequence, received(codec, sent.frames).sequence) << "in one piece";
  ASSERT_TRUE(std::ranges::is_sorted(got.complete));
  for (std::size_t i = 0; i < got.numbers.size(); ++i)
    ASSERT_EQ(got.sequence[i], got.numbers[i]) << "nothing is lost at a restart";
  EXPECT_EQ(got.counts.lost, sent.lost.size());
  EXPECT_EQ(got.numbers.size() + sent.lost.size(), sent.frames.back().number + 1);
  EXPECT_EQ(got.counts.channel_frames, got.numbers.size());
  EXPECT_EQ(got.counts.repeated.count, sent.repeated);
  EXPECT_EQ(got.counts.restarts.count, sent.restarts.size());
  EXPECT_EQ(got.counts.too_late.count, 0u);
}

TEST(FrameOrder, CountsExactlyWhateverTheOrderOfArrival) {
  for (const int bits : {8, 16, 32})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) expect_exact(bits, bits > 8, seed);
}

std::vector<SentFrame> counting(std::uint64_t number, std::uint64_t count, std::uint64_t counter) {
  std::vector<SentFrame> frames;
  for (std::uint64_t i = 0; i < count; ++i) frames.push_back({number + i, counter + i});
  return frames;
}

TEST(FrameOrder, AnExchangedPairLosesNothing) {
  const FrameCodec codec = codec_with_counter(32);
  auto sent = counting(0, 100, 500);
  for (std::size_t i = 10; i < 90; i += 4) std::swap(sent[i], sent[i + 1]);
  const ReceivedFrames got = received(codec, sent);
  EXPECT_EQ(got.sequence.back(), 99u);
  EXPECT_EQ(got.counts.lost, 0u);
  EXPECT_EQ(got.counts.exchanged.count, 20u);
  EXPECT_EQ(got.counts.restarts.count, 0u);
}

TEST(FrameOrder, ACounterThatBeginsAgainShowsNoLoss) {
  const FrameCodec codec = codec_with_counter(32);
  auto sent = counting(0, 50, 500);
  for (const SentFrame& frame : counting(50, 50, 0)) sent.push_back(frame);
  const ReceivedFrames got = received(codec, sent);
  EXPECT_EQ(got.counts.lost, 0u);
  EXPECT_EQ(got.counts.restarts.count, 1u);
  EXPECT_EQ(got.restarts.back(), 1u);
  EXPECT_EQ(got.sequence.back(), 99u);
}

TEST(FrameOrder, AFrameThatIsMuchTooLateIsRemovedAndReported) {
  const FrameCodec codec = codec_with_counter(16);
  auto sent = counting(0, 300, 500);
  std::rotate(sent.begin() + 50, sent.begin() + 51, sent.begin() + 200);  // 50 comes 149 frames later
  const ReceivedFrames got = received(codec, sent);
  EXPECT_EQ(got.sequence.back(), 299u);
  EXPECT_EQ(got.counts.lost, 1u);
  EXPECT_EQ(got.counts.too_late.count, 1u);
  EXPECT_EQ(got.counts.restarts.count, 0u);
}

TEST(FrameOrder, AnExchangedPairAtTheBeginMovesNothing) {
  auto sent = counting(0, 100, 500);
  std::swap(sent[0], sent[1]);
  const ReceivedFrames got = received(codec_with_counter(32), sent);
  EXPECT_EQ(got.numbers.front(), 1u);
  EXPECT_EQ(got.sequence.back(), 98u);
  EXPECT_EQ(got.counts.lost, 0u);
  EXPECT_EQ(got.counts.too_late.count, 1u);
}

TEST(FrameOrder, WhatWaitsAtTheEndIsHandedOut) {
  auto sent = counting(0, 60, 500);
  sent.erase(sent.begin() + 55);
  const ReceivedFrames got = received(codec_with_counter(32), sent);
  EXPECT_EQ(got.sequence.back(), 59u);
  EXPECT_EQ(got.counts.lost, 1u);
}

}  // namespace
}  // namespace tumble
