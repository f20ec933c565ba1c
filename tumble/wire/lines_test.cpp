// Frames that are lines of text, alone and between frames of bytes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "tumble/units/constants.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/wire/frames.hpp"
#include "tumble/wire/instruments.hpp"

namespace tumble {
namespace {

/// A fibre gyro that sends rate and temperature between spaces, without head and checksum.
FrameCodec fog_codec() {
  return read_frames(R"(title = "a fibre gyro"
certainty = "computed"
rate = "100 Hz"
[[frame]]
text = true
delimiter = " "
channel = [
  {name = "gyro", column = 0, scale = "1 deg/s", format = ".6"},
  {name = "temperature", column = 1, scale = "1 degC", format = ".2"},
]
[[vector]]
made_by_hand = true
line = "-0.012345 25.31"
values = {gyro = "-0.012345 deg/s", temperature = "25.31 degC"}
)",
                     "fog.toml");
}

/// Hexadecimal counts, a counter, a time, a word as status, and a sum.
FrameCodec hex_codec() {
  return read_frames(R"(title = "a device with hexadecimal cells"
certainty = "computed"
[[frame]]
text = true
head = "#"
delimiter = ";"
check = {kind = "sum", width = 16, between = ["#", "/"]}
counter = {column = 0, type = "u16", modulus = 1000, format = "03"}
time = {column = 1, scale = "1 ms"}
status = {column = 4, equals = "OK", text = "the device is ready"}
channel = [
  {name = "gyro", column = 2, type = "i24", digits = "hex", scale = "0.001 deg/s"},
  {name = "volts", column = 3, type = "u16", scale = "1 mV"},
]
[[vector]]
made_by_hand = true
line = "#007;12.5;FFFC18; 5000 ;OK/0566"
counter = 7
time = "0.0125 s"
values = {gyro = "-1.000 deg/s", volts = "5.000 V"}
)",
                     "hex.toml");
}

FrameCodec fixed_codec() {
  return read_frames(R"(title = "a device with cells of fixed width"
certainty = "computed"
rate = "10 Hz"
[[frame]]
text = true
head = "G"
end = "\r"
channel = {name = ["gyro.x", "gyro.y"], at = 1, width = 8, scale = "1 deg/h"}
[[vector]]
made_by_hand = true
line = "G   -1.25    12.5"
values = {"gyro.x" = "-1.25 deg/h", "gyro.y" = "12.5 deg/h"}
)",
                     "fixed.toml");
}

struct Decoded {
  std::vector<StreamFrame> frames;
  FrameCounts counts;
};

Decoded decoded(const FrameCodec& codec, std::string_view bytes, std::size_t piece) {
  Decoded result;
  FrameStream stream(codec);
  const auto sink = [&](const StreamFrame& frame) { result.frames.push_back(frame); };
  for (std::size_t at = 0; at < bytes.size(); at += piece) stream.feed(bytes.substr(at, piece), sink);
  stream.finish(sink);
  result.counts = stream.counts();
  return result;
}

TEST(Lines, EndByCrLfOrLf) {
  const FrameCodec codec = fog_codec();
  for (const std::string end : {"\r\n", "\n"}) {
    const auto content = decode_frame(codec, "-0.5\t 25" + end);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->values[0], si(-0.5, "deg/s"));
    EXPECT_EQ(encode_frame(codec, *content, "-0.5\t 25" + end), "-0.500000\t 25.00" + end) << "as declared";
  }
  EXPECT_FALSE(decode_frame(codec, "-0.5 25"));
  EXPECT_FALSE(decode_frame(codec, "-0.5 25 3\n")) << "columns are as declared";
  EXPECT_FALSE(decode_frame(codec, "-0,5 25\n")) << "not a number";
  EXPECT_FALSE(decode_frame(codec, "inf 25\n"));
}

TEST(Lines, WithoutHeadBeginBehindTheEndOfALine) {
  const FrameCodec codec = fog_codec();
  std::string bytes = "2345 25.31\r\n";  // the recording began in the middle of a line
  for (int i = 0; i < 20; ++i) {
    if (i == 5) bytes += "0.0000";              // the middle of a line is lost
    if (i == 9) bytes += "over temperature\n";  // a message
    if (i == 12) bytes += "\r\n";
    bytes += "0.5 25.31\r\n";
  }
  bytes += "0.25 2";  // the last is cut
  for (const std::size_t piece : {1u, 7u, 64u, 100000u}) {
    const Decoded all = decoded(codec, bytes, piece);
    ASSERT_EQ(all.frames.size(), 19u);
    EXPECT_EQ(all.counts.skipped.count, 1u);
    EXPECT_EQ(all.counts.skipped_bytes, 12u) << "the line with its end";
    EXPECT_EQ(all.counts.damaged.count, 2u) << "0.00000.5 is no number; and the message";
    EXPECT_EQ(all.counts.cut, 6u);
    EXPECT_EQ(all.frames.back().sequence, 18u + 2u + 2u) << "lost lines are estimated by the bytes between";
  }
}

TEST(Lines, MixWithFramesOfBytesInOneStream) {
  const FrameCodec codec = codec_of(find_instrument("vectornav"));
  std::string bytes = "00.002066,-00.008442*66\r\n";
  std::size_t lines = 0, frames = 0;
  for (int i = 0; i < 10; ++i)
    for (const FrameVector& vector : codec.vectors) {
      bytes += vector.bytes;
      ++(vector.bytes[0] == '$' ? lines : frames);
    }
  std::string wrong = codec.vectors.back().bytes.substr(0, 60) + "\r\n";
  bytes += wrong + codec.vectors[3].bytes.substr(0, 40) + codec.vectors[0].bytes;
  for (const std::size_t piece : {1u, 7u, 64u, 100000u}) {
    const Decoded all = decoded(codec, bytes, piece);
    EXPECT_EQ(all.counts.channel_frames, lines + frames + 1);
    EXPECT_EQ(all.counts.damaged.count, 2u) << "a line without checksum, and one that a frame of bytes cuts";
    EXPECT_EQ(all.counts.skipped.count, 1u);
    EXPECT_EQ(all.counts.cut, 0u);
  }
}

TEST(Lines, HoldCountersTimesWordsAndHexadecimalDigits) {
  const FrameCodec codec = hex_codec();
  FrameContent content{0, {si(1.234, "deg/s"), 3.3}, {1, 1}, 999, 0.02};
  const std::string line = encode_frame(codec, content);
  EXPECT_EQ(line.substr(0, 24), "#999;20;0004D2;3300;OK/0");
  const auto back = decode_frame(codec, line);
  ASSERT_TRUE(back);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_DOUBLE_EQ(back->values[i], content.values[i]);  // a product is rounded
  EXPECT_EQ(back->counter, 999u);
  EXPECT_EQ(*back->time, 0.02);
  std::string spoiled = line;
  spoiled[spoiled.find('3')] = '4';
  EXPECT_FALSE(decode_frame(codec, spoiled));
}

TEST(Lines, AreNotGoodWhereTheirWordIsAnother) {
  const FrameCodec codec = hex_codec();
  const auto content = decode_frame(codec, "#007;12.5;FFFC18; 5000 ;NO/0569\n");
  ASSERT_TRUE(content);
  EXPECT_EQ(content->not_good, 1u);
  EXPECT_TRUE(std::isnan(content->values[0]));
}

TEST(Lines, CellsThatAreNoNumbersAreMissingAndCounted) {
  const FrameCodec codec = hex_codec();
  const auto with_sum = [](const std::string& body) {
    unsigned sum = 0;
    for (const unsigned char c : body) sum += c;
    char digits[8];
    std::snprintf(digits, sizeof digits, "%04x", sum);
    return "#" + body + "/" + digits + "\r\n";
  };
  const Decoded all =
      decoded(codec, with_sum("1;1;000001;1;OK") + with_sum("2;2;GGG;70000;OK") + with_sum("3;3;;nan;OK"), 3);
  ASSERT_EQ(all.frames.size(), 3u) << "the checksum holds: this is what the device sent";
  EXPECT_EQ(all.counts.unreadable.count, 2u) << "70000 does not fit into u16; an empty cell is only missing";
  EXPECT_EQ(all.counts.unreadable.first, all.frames[1].offset);
  EXPECT_TRUE(std::isnan(all.frames[1].content.values[0]) && std::isnan(all.frames[2].content.values[1]));
  EXPECT_EQ(all.counts.damaged.count, 0u);
}

TEST(Lines, HaveCellsOfFixedWidth) {
  const FrameCodec codec = fixed_codec();
  const FrameContent content{0, {si(-0.5, "deg/h"), si(-123.75, "deg/h")}, {1, 1}};
  const std::string line = encode_frame(codec, content);
  EXPECT_EQ(line, "G    -0.5 -123.75\r");
  EXPECT_EQ(decode_frame(codec, line)->values, content.values);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.part = "does not fit into"}, [&] {
    encode_frame(codec, {0, {si(1.23456789, "deg/h"), 0.0}, {1, 1}});
  })) << "no room";
}

TEST(Lines, RefuseDeclarationsThatCannotBe) {
  const auto problems = [](const std::string& frame) {
    try {
      read_frames("title = \"a\"\ncertainty = \"computed\"\n[[frame]]\ntext = true\n" + frame, "a.toml");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::pair<const char*, const char*> cases[] = {
      {"delimiter = \"ab\"\nchannel = {name = \"a\", column = 0}", "delimiter: one character"},
      {"channel = [{name = \"a\", column = 0}, {name = \"b\", at = 3, width = 4}]", "and not both"},
      {"channel = {name = \"a\", column = 0, format = \"+x\"}", "format: sign, width and decimals"},
      {"columns = 2\nchannel = {name = \"a\", column = 4}", "columns: how many"},
      {"check = {kind = \"xor\", at = 3}\nchannel = {name = \"a\", column = 0}", "between"},
      {"channel = {name = \"a\", column = 0, type = \"f32\"}", "is no type of a cell"},
      {"end = \"ab\"\nchannel = {name = \"a\", column = 0}", "end: "},
      {"columns = 1", "recognised by its head"},
  };
  for (const auto& [frame, part] : cases)
    EXPECT_NE(problems(frame).find(part), std::string::npos) << frame << "\n" << problems(frame);
}

/// Flips, replaces, removes, inserts or repeats a few bytes; sometimes cuts the end.
std::string spoiled(std::string bytes, std::mt19937_64& random) {
  const std::string_view spice = "\r\n,;/*$#+-.eEnXx0 9\t";
  for (auto changes = 1 + random() % 6; changes-- > 0 && !bytes.empty();) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 6) {
      case 0:
        bytes[at] ^= static_cast<char>(1 << random() % 8);
        break;
      case 1:
        bytes[at] = spice[random() % spice.size()];
        break;
      case 2:
        bytes.erase(at, 1 + random() % 9);
        break;
      case 3:
        bytes.insert(at, 1, spice[random() % spice.size()]);
        break;
      case 4:
        bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 50));
        break;
      default:
        if (random() % 4 == 0) bytes.resize(at);
    }
  }
  return bytes;
}

void expect_same_in_pieces(const FrameCodec& codec, const std::string& bytes, std::size_t piece) {
  const Decoded whole = decoded(codec, bytes, bytes.size() + 1), parts = decoded(codec, bytes, piece);
  const FrameCounts &a = whole.counts, &b = parts.counts;
  ASSERT_EQ(a.channel_frames, b.channel_frames);
  ASSERT_EQ(std::tie(a.damaged.count, a.skipped_bytes, a.skipped.count, a.lost, a.cut, a.unreadable.count),
            std::tie(b.damaged.count, b.skipped_bytes, b.skipped.count, b.lost, b.cut, b.unreadable.count));
  ASSERT_LE(a.good_bytes + a.skipped_bytes + a.cut, bytes.size());
  for (const StreamFrame& frame : whole.frames)
    for (const double value : frame.content.values) ASSERT_FALSE(std::isinf(value));
}

TEST(Lines, AreDecodedInPiecesAsInOneForHostileBytes) {
  std::mt19937_64 random(11);
  for (const FrameCodec& codec : {fog_codec(), hex_codec(), fixed_codec(), codec_of(find_instrument("vectornav")),
                                  codec_of(find_instrument("kvh_dsp"))}) {
    std::string stream;
    FrameContent content = *decode_frame(codec, codec.vectors[0].bytes);
    for (std::uint64_t i = 0; i < 24; ++i) {
      content.counter = i % 4;
      stream += encode_frame(codec, content, codec.vectors[0].bytes);
      if (!codec.frames[0].counter) stream += codec.vectors[i % codec.vectors.size()].bytes;
    }
    for (int i = 0; i < 2000; ++i) {
      SCOPED_TRACE(codec.title + ", mutation " + std::to_string(i));
      expect_same_in_pieces(codec, spoiled(stream, random), 1 + random() % 40);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace tumble
