#include "tumble/wire/frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/wire/codec/encode.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace {

/// Calls `test` with every shipped declaration, without variants and in each variant.
template <class Test>
void for_each_codec(Test test) {
  for (const auto& instrument : shipped_instruments()) {
    std::vector<std::vector<std::string>> choices{{}};
    for (const auto& variant : instrument.variants) choices.push_back({variant});
    for (const auto& variants : choices) {
      SCOPED_TRACE(std::string(instrument.name) + (variants.empty() ? "" : ":" + variants[0]));
      test(codec_of(instrument, variants));
    }
  }
}

std::string text_of_vector(const std::string& tail) {
  return R"(title = "a device"
certainty = "computed"
[[frame]]
name = "data"
sync = "AA 55"
length = 9
check = {kind = "sum", over = [0, -1], at = -1}
counter = {at = 2, type = "u8"}
channel = [{name = ["a", "b"], at = 3, type = "i16", scale = "0.5 deg/s"}]
)" + tail;
}

constexpr const char* vector_text = R"(
[[vector]]
made_by_hand = true
hex = "AA 55 07 02 00 FE FF 00 05"
counter = 7
values = {a = "1 deg/s", b = "-1 deg/s"}
)";

FrameCodec small_codec() { return read_frames(text_of_vector(vector_text), "device.toml"); }

/// Random content for a layout: raw numbers of every field, in the order of the fields.
FrameContent random_content(const FrameCodec& codec, std::size_t frame, std::mt19937_64& random) {
  const FrameLayout& layout = codec.frames[frame];
  FrameContent content;
  content.frame = frame;
  content.values.assign(codec.channels.size(), std::nan(""));
  content.present.assign(codec.channels.size(), 0);
  if (layout.counter) content.counter = random() % layout.counter->modulus;
  if (!layout.time.empty()) content.time = static_cast<double>(random() % 600000) * layout.time[0].factor;
  std::set<std::size_t> done;
  for (const FrameField& field : layout.fields) {
    const bool muxed = field.when && field.when->modulus > 0;
    if (muxed && *content.counter % field.when->modulus != field.when->equals) continue;
    if (!done.insert(field.channel).second) continue;
    const double top = std::ldexp(1.0, std::min(field.number.bits, 50) - 1);
    double raw = std::floor((std::uniform_real_distribution<>(-1.0, 1.0)(random)) * top);
    if (field.number.kind == FrameNumber::Kind::natural) raw = std::abs(raw);
    if (field.number.kind == FrameNumber::Kind::real) raw = static_cast<float>(raw / top);
    if (field.number.form == FrameNumber::Form::decimal && field.number.kind == FrameNumber::Kind::real)
      raw = std::stod(codec::written(layout.text->cells[static_cast<std::size_t>(field.number.item)].format, raw));
    content.values[field.channel] = raw * field.factor + field.zero;
    content.present[field.channel] = 1;
  }
  return content;
}

/// Random contents of every layout of the codec come back as they were.
void expect_round_trips(const FrameCodec& codec) {
  std::mt19937_64 random(7);
  for (std::size_t frame = 0; frame < codec.frames.size(); ++frame)
    for (int trial = 0; trial < 50 && !codec.frames[frame].fields.empty(); ++trial) {
      SCOPED_TRACE(codec.frames[frame].name);
      const FrameContent content = random_content(codec, frame, random);
      const auto decoded = decode_frame(codec, encode_frame(codec, content));
      ASSERT_TRUE(decoded);
      EXPECT_EQ(decoded->frame, frame);
      EXPECT_EQ(decoded->counter, content.counter);
      EXPECT_EQ(decoded->present, content.present);
      for (std::size_t i = 0; i < codec.channels.size(); ++i)
        EXPECT_TRUE(!content.present[i] || decoded->values[i] == content.values[i]) << codec.channels[i].name;
    }
}

TEST(ShippedInstruments, VectorsHoldBothWays) {
  for_each_codec(
      [](const FrameCodec& codec) { EXPECT_EQ(texts_of(problems_of_vectors(codec)), std::vector<std::string>{}); });
}

TEST(ShippedInstruments, WhatIsEncodedIsDecoded) { for_each_codec(expect_round_trips); }

TEST(ShippedInstruments, FramesThatAreEncodedOneAfterTheOtherAreThoseOfOneAlone) {
  for_each_codec([](const FrameCodec& codec) {
    std::mt19937_64 random(11);
    FrameEncoder encoder;
    std::string together, alone;
    for (int trial = 0; trial < 20; ++trial)
      for (std::size_t frame = 0; frame < codec.frames.size(); ++frame)
        for (int again = 0; again < 3 && !codec.frames[frame].fields.empty(); ++again) {
          const FrameContent content = random_content(codec, frame, random);
          encoder.append(codec, content, together);
          alone += encode_frame(codec, content);
        }
    EXPECT_TRUE(together == alone);
  });
}

TEST(ShippedInstruments, EachHasAVectorForItself) {
  for (const auto& instrument : shipped_instruments()) {
    std::size_t vectors = codec_of(instrument).vectors.size();
    for (const auto& variant : instrument.variants) vectors += codec_of(instrument, {variant}).vectors.size();
    EXPECT_GT(vectors, 0u) << instrument.name;
  }
}

TEST(ReadFrames, SaysEveryProblemWithItsLine) {
  EXPECT_TRUE(refuses(Error::Kind::bad_input,
                      {{.values = {"colour"}, .file = "device.toml", .table = "[[frame]] 'data'", .line = 10},
                       {.values = {"G"}, .table = "[[frame]]", .key = "sync", .line = 12},
                       {.values = {"x7"}, .key = "type", .line = 14},
                       {.values = {"1", "9", "4"}, .pattern = "do not lie in a frame", .key = "at"},
                       {.values = {"2^"}, .pattern = "is no scale", .key = "scale"}},
                      [] {
                        read_frames(text_of_vector("colour = 3\n") +
                                        "[[frame]]\nsync = \"AG\"\nlength = 4\n"
                                        "channel = [{name = \"a\", at = 9, type = \"x7\", scale = \"2^ deg\"}]\n",
                                    "device.toml");
                      }));
}

TEST(ReadFrames, NeedsAVectorThatHolds) {
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "there is no [[vector]]"},
                      [&] { read_frames(text_of_vector(""), "device.toml"); }));
  std::string wrong = vector_text;
  wrong.replace(wrong.find("\"1 deg/s\""), 9, "\"2 deg/s\"");
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input,
              Asked{.values = {"a"}, .pattern = "and should be", .file = "device.toml", .table = "vector", .line = 11},
              [&] { read_frames(text_of_vector(wrong), "device.toml"); }));
}

TEST(FrameStream, FindsTheNextFrameAfterGarbageAndCountsWhatIsMissing) {
  const FrameCodec codec = small_codec();
  FrameContent content{0, {si(1.0, "deg/s"), si(2.0, "deg/s")}, {1, 1}, 0};
  std::string bytes = "junk\xAA\x55";
  std::vector<std::uint64_t> counters;
  for (std::uint64_t i = 0; i < 300; ++i) {
    if (i == 50 || i == 51) continue;  // two are lost
    content.counter = i % 256;
    std::string frame = encode_frame(codec, content);
    if (i == 100) frame[4] ^= 1;                   // one is damaged
    if (i == 200) bytes += frame;                  // one comes twice
    if (i == 250) frame += "noise \xAA\x55 \xAA";  // noise between two
    bytes += frame;
  }
  bytes += encode_frame(codec, content).substr(0, 5);  // the last is cut
  for (const std::size_t piece : {1u, 7u, 64u, 100000u}) {
    FrameStream stream(codec);
    std::vector<std::uint64_t> sequence;
    const auto sink = [&](const StreamFrame& frame) { sequence.push_back(frame.sequence); };
    for (std::size_t at = 0; at < bytes.size(); at += piece)
      stream.feed(std::string_view(bytes).substr(at, piece), sink);
    stream.finish(sink);
    const FrameCounts& counts = stream.counts();
    EXPECT_EQ(counts.channel_frames, 297u);
    EXPECT_EQ(sequence.size(), 297u);
    EXPECT_EQ(sequence.back(), 299u) << "lost frames are counted";
    EXPECT_EQ(counts.gaps.count, 2u);
    EXPECT_EQ(counts.lost, 3u);
    EXPECT_EQ(counts.repeated.count, 1u);
    EXPECT_EQ(counts.damaged.count, 1u);
    EXPECT_EQ(counts.damaged.first, 6u + 98u * 9u);
    EXPECT_EQ(counts.skipped.count, 2u) << "the junk before and the noise";
    EXPECT_EQ(counts.skipped_bytes, 6u + 10u);
    EXPECT_EQ(counts.cut, 5u);
  }
}

TEST(FrameStream, CountsGapsAcrossTheWrapOfTheCounter) {
  const FrameCodec codec = codec_of(find_instrument("kvh_1775"));
  FrameContent content;
  content.values.assign(codec.channels.size(), 0.0);
  content.present.assign(codec.channels.size(), 0);
  content.present[0] = 1;
  FrameStream stream(codec);
  std::uint64_t last = 0;
  for (const std::uint64_t counter : {125, 126, 127, 0, 4, 5}) {
    content.counter = counter;
    stream.feed(encode_frame(codec, content), [&](const StreamFrame& frame) { last = frame.sequence; });
  }
  stream.finish([&](const StreamFrame& frame) { last = frame.sequence; });  // they wait for those that are missing
  EXPECT_EQ(last, 8u);
  EXPECT_EQ(stream.counts().lost, 3u);
}

TEST(FrameStream, LearnsTheStepOfACounterThatCountsFaster) {
  const FrameCodec codec = codec_of(find_instrument("stim300"));
  FrameContent content;
  content.values.assign(codec.channels.size(), 0.0);
  content.present.assign(codec.channels.size(), 0);
  FrameStream stream(codec);
  for (std::uint64_t i = 0; i < 400; ++i) {
    if (i == 333) continue;
    content.counter = 4 * i % 256;  // 500 Hz
    stream.feed(encode_frame(codec, content), [](const StreamFrame&) {});
  }
  EXPECT_EQ(stream.counts().gaps.count, 1u);
  EXPECT_EQ(stream.counts().lost, 1u);
}

TEST(FrameStream, UnwrapsTheClockOfTheDevice) {
  const FrameCodec codec = codec_of(find_instrument("sbg_ecom"));
  FrameContent content;
  content.values.assign(codec.channels.size(), 0.0);
  content.present.assign(codec.channels.size(), 0);
  FrameStream stream(codec);
  const double wrap = std::ldexp(1e-6, 32);
  double last = 0.0;
  for (const double time : {wrap - 0.01, wrap - 0.005, 0.0, 0.005}) {
    content.time = time;
    stream.feed(encode_frame(codec, content), [&](const StreamFrame& frame) { last = *frame.time; });
  }
  EXPECT_NEAR(last, wrap + 0.005, 2e-6);  // two counts of the clock of the device, 1 us each
}

TEST(FrameStatus, BlanksTheChannelsItIsAbout) {
  const FrameCodec codec = codec_of(find_instrument("kvh_1775"));
  std::string bytes = codec.vectors[0].bytes;
  auto content = decode_frame(codec, bytes);
  ASSERT_TRUE(content);
  FrameContent same = *content;
  bytes[28] = 0x76;  // gyro x is not valid
  const std::string spoiled =
      encode_frame(codec, {0, {}, std::vector<unsigned char>(codec.channels.size()), {}, {}}, bytes);
  content = decode_frame(codec, spoiled);
  ASSERT_TRUE(content) << "the checksum was made again";
  EXPECT_TRUE(content->present[0] && std::isnan(content->values[0]));
  EXPECT_EQ(content->values[1], same.values[1]);
}

TEST(ParseInstrument, SeparatesVariants) {
  const auto choice = parse_instrument("a:b.toml:fast,wide");
  EXPECT_EQ(choice.name, "a:b.toml");
  EXPECT_EQ(choice.variants, (std::vector<std::string>{"fast", "wide"}));
  EXPECT_EQ(parse_instrument("kvh_1775").variants.size(), 0u);
}

}  // namespace
}  // namespace tumble
