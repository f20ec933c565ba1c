#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <tuple>

#include "tumble/wire/instruments.hpp"

/// Streams that are spoiled, for every declaration of an instrument: 10^4 inputs each, or TUMBLE_FUZZ_INPUTS.
namespace tumble {
namespace {

using StreamRandom = std::mt19937_64;

std::size_t wanted_inputs() {
  const char* const text = std::getenv("TUMBLE_FUZZ_INPUTS");
  return text == nullptr ? 10000 : static_cast<std::size_t>(std::strtoull(text, nullptr, 10));
}

/// Whether a vector is one of the codec in its variant.
bool holds_for(const FrameCodec& codec, const FrameVector& vector) {
  return decode_frame(codec, vector.bytes).has_value();
}

/// The frames of a declaration; where its numbers have a meaning only in a variant, in the first one with vectors.
FrameCodec codec_to_spoil(const std::string& name) {
  const auto& instrument = find_instrument(name);
  FrameCodec codec = codec_of(instrument);
  for (const auto& variant : instrument.variants) {
    if (codec.unchosen.empty() && !codec.vectors.empty()) break;
    codec = codec_of(instrument, {variant});
  }
  return codec;
}

/// Frames that follow each other as an instrument sends them: those of the vectors, with counters that count.
std::string sound_stream(const FrameCodec& codec, std::size_t frames) {
  std::vector<FrameContent> contents;
  for (const auto& vector : codec.vectors)
    if (const auto content = decode_frame(codec, vector.bytes))
      if (std::ranges::count(content->present, 1) > 0) contents.push_back(*content);
  std::string bytes;
  for (std::size_t k = 0; k < frames && !contents.empty(); ++k) {
    FrameContent content = contents.front();
    const auto& layout = codec.frames[content.frame];
    if (layout.counter) content.counter = (content.counter.value_or(0) + k) % layout.counter->modulus;
    try {
      bytes += encode_frame(codec, content, codec.vectors.front().bytes);
    } catch (const std::exception&) {
      return "";
    }
  }
  return bytes;
}

/// One to six places where a bit is turned over, bytes are lost, come twice, or are noise; sometimes the end is cut
/// off.
std::string spoiled_stream(std::string bytes, StreamRandom& random) {
  for (auto changes = 1 + random() % 6; changes-- > 0 && !bytes.empty();) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 5) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
        break;
      case 1:
        bytes.erase(at, 1 + random() % 9);
        break;
      case 2:
        bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 60));
        break;
      case 3:
        for (auto noise = 1 + random() % 12; noise-- > 0;) bytes.insert(at, 1, static_cast<char>(random() % 256));
        break;
      default:
        if (random() % 4 == 0) bytes.resize(at);
    }
  }
  return bytes;
}

struct DecodedStream {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> frames;  ///< end and sequence
  FrameCounts counts;
};

DecodedStream decoded_stream(const FrameCodec& codec, const std::string& bytes, StreamRandom* pieces) {
  DecodedStream all;
  FrameStream stream(codec);
  const auto take = [&](const StreamFrame& frame) { all.frames.emplace_back(frame.complete, frame.sequence); };
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t count = pieces ? 1 + (*pieces)() % 40 : bytes.size();
    stream.feed(std::string_view(bytes).substr(at, count), take);
    at += count;
  }
  stream.finish(take);
  all.counts = stream.counts();
  return all;
}

class InstrumentFuzz : public ::testing::TestWithParam<std::string> {};

/// What is decoded does not depend on how the bytes arrive; each byte is in a frame, or counted, or waits at the end;
/// and the sequence of the frames does not go back (frames without a counter may share a number).
TEST_P(InstrumentFuzz, SpoiledStreamsAreDecodedAlikeInAnyPieces) {
  const FrameCodec codec = codec_to_spoil(GetParam());
  std::string sound;
  for (const auto& vector : codec.vectors)
    if (holds_for(codec, vector)) sound += vector.bytes + codec.between;
  sound += sound_stream(codec, 6);
  ASSERT_FALSE(sound.empty());
  StreamRandom random(31);
  for (std::size_t input = 0; input < wanted_inputs(); ++input) {
    const std::string bytes = spoiled_stream(sound, random);
    const DecodedStream whole = decoded_stream(codec, bytes, nullptr), parts = decoded_stream(codec, bytes, &random);
    const FrameCounts &a = whole.counts, &b = parts.counts;
    ASSERT_EQ(whole.frames, parts.frames) << "input " << input;
    ASSERT_EQ(
        std::tie(a.bytes, a.good, a.damaged.count, a.skipped_bytes, a.lost, a.repeated.count, a.exchanged.count, a.cut),
        std::tie(b.bytes, b.good, b.damaged.count, b.skipped_bytes, b.lost, b.repeated.count, b.exchanged.count, b.cut))
        << "input " << input;
    ASSERT_LE(a.good_bytes + a.skipped_bytes + a.cut, bytes.size()) << "input " << input;
    for (std::size_t i = 1; i < whole.frames.size(); ++i) {
      ASSERT_GE(whole.frames[i].first, whole.frames[i - 1].first) << "input " << input;
      ASSERT_GE(whole.frames[i].second, whole.frames[i - 1].second) << "input " << input;
    }
  }
}

/// Behind a spoiled stream, sound frames are found again: at most those of the longest frame that noise may have begun
/// are missing.
TEST_P(InstrumentFuzz, SoundFramesBehindThemAreFoundAgain) {
  const FrameCodec codec = codec_to_spoil(GetParam());
  const std::string sound = sound_stream(codec, 200);
  if (sound.empty()) GTEST_SKIP() << "its vectors cannot be continued";
  StreamRandom random(37);
  for (std::size_t input = 0; input < wanted_inputs() / 20; ++input) {
    const std::string before = spoiled_stream(sound.substr(0, sound.size() / 50), random);
    const DecodedStream all = decoded_stream(codec, before + sound, nullptr);
    ASSERT_FALSE(all.frames.empty()) << "input " << input;
    ASSERT_GE(all.frames.back().first, before.size() + sound.size() - 2 * sound.size() / 200) << "input " << input;
  }
}

std::vector<std::string> names_of_instruments() {
  std::vector<std::string> names;
  for (const auto& instrument : shipped_instruments()) names.emplace_back(instrument.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Shipped, InstrumentFuzz, ::testing::ValuesIn(names_of_instruments()),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace tumble
