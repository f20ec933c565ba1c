#include "tumble/formats/format.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <functional>
#include <random>
#include <sstream>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/file/plain_value.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Values that a file could have said: decimals with up to 17 digits in the unit.
Recording sample(std::size_t count, const Timeline& timeline = {0.5, 400.0, nullptr}) {
  std::mt19937_64 random(99);
  std::normal_distribution<double> normal;
  Recording recording;
  recording.instrument = "FOG-1 \"serial\" 17";
  recording.marks = {{"static", 0.5, 1}, {"ramp \u00b0", 1.25, 2}};
  recording.meta = {{"operator", "N. N."}, {"note", "line\nbreak, comma; # and \\"}};
  for (const char* spec : {"gyro.x/deg/h", "acc/g", "case temperature/degC", "T/K", "angle/arcsec", "n/count", "r/1"}) {
    const std::string text(spec);
    const auto slash = text.find('/');
    Channel channel{text.substr(0, slash), QuantityKind::other, Unit::parse(text.substr(slash + 1)), timeline, {}};
    channel.kind = kind_of(channel.unit);
    for (std::size_t i = 0; i < count; ++i) {
      const double value = i % 3 == 0 ? std::round(normal(random) * 1e4) / 1e4 : normal(random);
      channel.values.push_back(i % 11 == 5 ? std::nan("") : channel.unit.to_si(value));
    }
    recording.channels.push_back(channel);
  }
  recording.channels.back().kind = QuantityKind::angle;  // not what the unit says
  return recording;
}

void expect_same(const Recording& a, const Recording& b) {
  EXPECT_EQ(a.instrument, b.instrument);
  EXPECT_EQ(a.meta, b.meta);
  ASSERT_EQ(a.marks.size(), b.marks.size());
  for (std::size_t i = 0; i < a.marks.size(); ++i) {
    EXPECT_EQ(a.marks[i].label, b.marks[i].label);
    EXPECT_EQ(a.marks[i].begin, b.marks[i].begin);
    EXPECT_EQ(a.marks[i].run, b.marks[i].run);
  }
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t i = 0; i < a.channels.size(); ++i) {
    const Channel &left = a.channels[i], &right = b.channels[i];
    EXPECT_EQ(left.name, right.name);
    EXPECT_EQ(left.unit, right.unit);
    EXPECT_EQ(left.kind, right.kind) << left.name;
    EXPECT_EQ(left.timeline.uniform(), right.timeline.uniform());
    EXPECT_EQ(left.timeline.start, right.timeline.start);
    EXPECT_EQ(left.timeline.rate, right.timeline.rate);
    if (!left.timeline.uniform() && !right.timeline.uniform()) {
      EXPECT_EQ(*left.timeline.stamps, *right.timeline.stamps);
    }
    ASSERT_EQ(left.values.size(), right.values.size());
    for (std::size_t k = 0; k < left.values.size(); ++k)
      ASSERT_TRUE(left.values[k] == right.values[k] || (std::isnan(left.values[k]) && std::isnan(right.values[k])))
          << left.name << " " << k << ": " << left.values[k] << " " << right.values[k];
  }
}

struct Formats : testing::TestWithParam<const char*> {
  ScratchFolder folder;
  std::string file(const std::string& stem) const { return folder.file(stem + GetParam()); }
  static Recording read(const std::string& path) { return read_recording(path, {}, {}); }
};

TEST_P(Formats, RecordingComesBackExactly) {
  const auto recording = sample(3000);
  write_recording(recording, file("a"));
  expect_same(recording, read(file("a")));
  EXPECT_EQ(folder.entries(), 1u);
}

TEST_P(Formats, UnevenStampsComeBackExactlyAndShared) {
  std::mt19937_64 random(3);
  std::vector<double> stamps;
  for (int k = 0; k < 1000; ++k) stamps.push_back(1e3 + k + std::uniform_real_distribution<>(-0.3, 0.3)(random));
  stamps[500] = stamps[400];  // a clock that ran backwards is not mended
  const auto shared = std::make_shared<const std::vector<double>>(stamps);
  const auto recording = sample(1000, {0.0, 0.0, shared});
  write_recording(recording, file("a"));
  const auto back = read(file("a"));
  expect_same(recording, back);
  EXPECT_EQ(back.channels[0].timeline.stamps, back.channels[3].timeline.stamps);
}

TEST_P(Formats, OddRatesComeBackExactly) {
  for (const double rate : {1.0 / 3.0, 99.98765432109876, 3072.000001, 1e-3})
    for (const double start : {0.0, -17.123456789, 1.7e9}) {
      const auto recording = sample(100, {start, rate, nullptr});
      write_recording(recording, file("a"));
      const auto back = read(file("a"));
      EXPECT_EQ(back.channels[0].timeline.rate, rate);
      EXPECT_EQ(back.channels[0].timeline.start, start);
    }
}

TEST_P(Formats, StreamGivesTheBlocksOfTheWhole) {
  write_recording(sample(5000), file("a"));
  const auto whole = read(file("a"));
  for (const Format* format : format_catalogue()) {
    if (!format->recognises(file("a"))) continue;
    Recording joined;
    std::size_t blocks = 0;
    format->stream(file("a"), {}, 1024,
                   [&](const Recording& block) {
                     if (blocks++ == 0) {
                       joined = block;
                       return;
                     }
                     for (std::size_t i = 0; i < block.channels.size(); ++i) {
                       Channel& to = joined.channels[i];
                       const Channel& from = block.channels[i];
                       EXPECT_NEAR(from.timeline.start, to.timeline.time(to.values.size()), 1e-9);
                       to.values.insert(to.values.end(), from.values.begin(), from.values.end());
                     }
                   },
                   {});
    EXPECT_GE(blocks, 4u);
    expect_same(whole, joined);
  }
}

TEST_P(Formats, ConvertsToEveryOther) {
  write_recording(sample(100000), file("a"));
  const auto whole = read(file("a"));
  for (const char* extension : {".csv", ".h5"}) {
    convert(file("a"), folder.file(std::string("b") + extension), {}, {});
    expect_same(whole, read(folder.file(std::string("b") + extension)));
  }
}

TEST_P(Formats, OnlyWantedChannels) {
  write_recording(sample(10), file("a"));
  ReadOptions options;
  options.only = {"acc", "not there"};
  const auto recording = read_recording(file("a"), options, {});
  ASSERT_EQ(recording.channels.size(), 1u);
  EXPECT_EQ(recording.channels[0].name, "acc");
}

TEST_P(Formats, InfiniteSamplesAreNotWritten) {
  auto recording = sample(10);
  recording.channels[1].values[3] = INFINITY;
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.pattern = "infinite"}, [&] { write_recording(recording, file("a")); }));
  EXPECT_EQ(folder.entries(), 0u);
}

TEST_P(Formats, NothingRemainsWithoutCommit) {
  for (const Format* format : format_catalogue())
    if (format->extensions.front() == GetParam()) format->writer(file("a")).append(sample(10));
  EXPECT_EQ(folder.entries(), 0u);
}

// A limit on the file size fails writes as a full disk does, and needs no privilege.
TEST_P(Formats, FullDiskIsSaidAndLeavesNothing) {
  write_recording(sample(10), file("old"));
  const auto old = read_text_file(file("old"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t size : {rlim_t{100}, rlim_t{5000}, rlim_t{100000}, rlim_t{3000000}}) {
    const rlimit small{size, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const Refused refused = refusal_of([&] { write_recording(sample(100000), file("old")); });
    setrlimit(RLIMIT_FSIZE, &before);
    const std::string reason = std::system_category().message(EFBIG);
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {file("old")}, .part = reason}, refused)) << size;
    EXPECT_EQ(folder.entries(), 1u);
    EXPECT_EQ(read_text_file(file("old")), old);
  }
  std::signal(SIGXFSZ, handler);
  write_recording(sample(10), file("old"));  // and everything still works
  expect_same(read(file("old")), sample(10));
}

TEST_P(Formats, OneSampleIsARecording) {
  auto recording = sample(1);
  write_recording(recording, file("a"));
  EXPECT_EQ(read(file("a")).channels[0].values.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(All, Formats, testing::Values(".csv", ".h5"),
                         [](const auto& param) { return std::string(param.param).substr(1); });

TEST(FormatChoice, RefusalsNameTheFile) {
  ScratchFolder folder;
  const auto file = Error::Kind::bad_file, input = Error::Kind::bad_input;
  const std::string none = folder.file("none.csv"), whole = folder.path.string();
  const std::string absent = std::system_category().message(ENOENT);
  EXPECT_TRUE(refuses(file, Asked{.values = {none}, .part = absent}, [&] { read_recording(none, {}, {}); }));
  EXPECT_TRUE(refuses(file, Asked{.values = {whole}, .pattern = "folder"}, [&] { read_recording(whole, {}, {}); }));
  EXPECT_TRUE(refuses(file, Asked{.values = {"/dev/null"}, .pattern = "not a regular file"},
                      [&] { read_recording("/dev/null", {}, {}); }));
  EXPECT_TRUE(refuses(input, Asked{.part = ".csv, "}, [&] { write_recording(sample(3), folder.file("a.xyz")); }));
  for (const char* name : {"a.csv", "a.h5"})
    EXPECT_TRUE(refuses(input, Asked{.pattern = "no channel"}, [&] { write_recording({}, folder.file(name)); }));
  write_file_atomically(folder.file("a.bin"), std::string("\0\1\2", 3));
  EXPECT_TRUE(refuses(file, Asked{.part = "a.bin", .pattern = "not a recording"},
                      [&] { read_recording(folder.file("a.bin"), {}, {}); }));
  write_file_atomically(folder.file("a.h5"), "");
  EXPECT_TRUE(refuses(file, Asked{.values = {folder.file("a.h5")}, .pattern = "is empty"},
                      [&] { read_recording(folder.file("a.h5"), {}, {}); }));
  EXPECT_EQ(folder.entries(), 2u);
}

TEST(FormatChoice, ChannelsOfDifferentRatesGoToHdf5) {
  ScratchFolder folder;
  auto recording = sample(100);
  recording.channels[2].timeline.rate = 4.0;
  recording.channels[2].values.resize(7);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "sampled at different times"},
                      [&] { write_recording(recording, folder.file("a.csv")); }));
  write_recording(recording, folder.file("a.h5"));
  expect_same(recording, read_recording(folder.file("a.h5"), {}, {}));
}

/// A format that is only read: a line "RATE Hz", then one value [deg/s] a line.
namespace listing {

bool recognises(const std::string& path) { return read_text_file(path).starts_with("RATE "); }

Recording read(const std::string& path, const ReadOptions&, const Progress&) {
  std::istringstream lines(read_text_file(path));
  std::string word;
  double rate = 0.0;
  lines >> word >> rate;
  if (!(rate > 0.0))
    throw Error(Error::Kind::bad_file, say("{}: RATE is followed by a rate [Hz] above zero", Name{path}));
  const Unit unit = Unit::parse("deg/s");
  Recording recording{"listing", {{"gyro", kind_of(unit), unit, {0.0, rate, nullptr}, {}}}, {}, {path}, {}, {}};
  recording.marks = {{"static", 0.0, 1}};
  recording.origin.checksum = [] { return std::string("checksum"); };
  while (lines >> word) recording.channels[0].values.push_back(unit.to_si(std::stod(word)));
  return recording;
}

const Format format{
    .name = "listing", .summary = "values", .extensions = {".lst"}, .recognises = recognises, .read = read};

/// The catalogue with this format; before csv, which reads all text.
FormatList formats() {
  FormatList all{&format};
  all.insert(all.end(), format_catalogue().begin(), format_catalogue().end());
  return all;
}

}  // namespace listing

/// 100 Hz, `count` values: 0.5, 1.5, ... [deg/s].
void write_listing(const std::string& path, int count) {
  std::string text = "RATE 100\n";
  for (int i = 0; i < count; ++i) text += std::to_string(i) + ".5\n";
  write_file_atomically(path, text);
}

TEST(ReadOnlyFormat, IsReadByItsContent) {
  ScratchFolder folder;
  write_listing(folder.file("a"), 7);
  const auto recording = read_recording(folder.file("a"), {}, {}, listing::formats());
  ASSERT_EQ(recording.channels.size(), 1u);
  ASSERT_EQ(recording.channels[0].values.size(), 7u);
  EXPECT_EQ(recording.channels[0].values[6], Unit::parse("deg/s").to_si(6.5));
}

TEST(ReadOnlyFormat, TakesTheMemoryOfItsFile) {
  ScratchFolder folder;
  write_listing(folder.file("a.lst"), 7);
  EXPECT_EQ(recording_memory(listing::format, folder.file("a.lst"), {}),
            std::filesystem::file_size(folder.file("a.lst")));
}

TEST(ReadOnlyFormat, StreamsItsWholeInBlocks) {
  ScratchFolder folder;
  write_listing(folder.file("a.lst"), 1000);
  const auto whole = read_recording(folder.file("a.lst"), {}, {}, listing::formats());
  Recording joined;
  std::size_t blocks = 0;
  const auto join = [&](const Recording& block) {
    EXPECT_FALSE(block.origin.checksum);
    EXPECT_LE(block.channels[0].values.size(), 64u);
    if (blocks++ == 0) {
      joined = block;
      return;
    }
    auto& values = joined.channels[0].values;
    EXPECT_EQ(block.channels[0].timeline.start, whole.channels[0].time(values.size()));
    values.insert(values.end(), block.channels[0].values.begin(), block.channels[0].values.end());
  };
  stream_recording(listing::format, folder.file("a.lst"), {}, 64, join, {});
  EXPECT_EQ(blocks, 16u);  // 1000 / 64, rounded up
  expect_same(joined, whole);
}

TEST(ReadOnlyFormat, BlocksOfManyRatesJoinToTheWhole) {
  static Recording whole;  // two channels that share uneven stamps, one of another rate, one without a sample
  whole = sample(500);
  const auto shared = std::make_shared<std::vector<double>>();
  for (int k = 0; k < 500; ++k) shared->push_back(k + 0.1 * (k % 3));
  whole.channels[1].timeline = whole.channels[2].timeline = {0.0, 0.0, shared};
  whole.channels[3].values.resize(7);
  whole.channels[4].values.clear();
  Format format = listing::format;
  format.read = [](const std::string&, const ReadOptions&, const Progress&) { return whole; };
  std::vector<std::vector<double>> values(whole.channels.size()), times(whole.channels.size());
  const auto join = [&](const Recording& block) {
    EXPECT_EQ(block.channels[1].timeline.stamps, block.channels[2].timeline.stamps);
    for (std::size_t i = 0; i < values.size(); ++i)
      for (std::size_t k = 0; k < block.channels[i].values.size(); ++k) {
        values[i].push_back(block.channels[i].values[k]);
        times[i].push_back(block.channels[i].time(k));
      }
  };
  stream_recording(format, "", {}, 30, join, {});
  for (std::size_t i = 0; i < values.size(); ++i) {
    ASSERT_EQ(values[i].size(), whole.channels[i].values.size());
    for (std::size_t k = 0; k < values[i].size(); ++k) {
      EXPECT_TRUE(values[i][k] == whole.channels[i].values[k] || std::isnan(values[i][k])) << i << " " << k;
      EXPECT_NEAR(times[i][k], whole.channels[i].time(k), 1e-12);  // start and part are rounded once each, below 500 s
    }
  }
}

TEST(ReadOnlyFormat, ConvertsToOneThatCanBeWritten) {
  ScratchFolder folder;
  write_listing(folder.file("a.lst"), 100000);
  convert(folder.file("a.lst"), folder.file("b.h5"), {}, {}, listing::formats());
  auto expected = read_recording(folder.file("a.lst"), {}, {}, listing::formats());
  expect_same(read_recording(folder.file("b.h5"), {}, {}), expected);
}

TEST(ReadOnlyFormat, IsRefusedAsTargetBeforeAnythingIsWritten) {
  ScratchFolder folder;
  const auto formats = listing::formats();
  const auto target = folder.file("b.lst"), source = folder.file("a.csv");
  write_recording(sample(10), source);
  const std::vector<std::function<void()>> attempts{
      [&] { write_recording(sample(10), target, formats); }, [&] { recording_writer(target, formats); },
      [&] { format_to_write(target, formats); }, [&] { convert(source, target, {}, {}, formats); }};
  for (const auto& attempt : attempts) try {
      attempt();
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind, Error::Kind::bad_input);
      const std::string message = error.what();
      for (const char* part : {"b.lst", "format listing", "csv (.csv, .txt", "hdf5 (.h5"})
        EXPECT_NE(message.find(part), std::string::npos) << message;
    }
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_EQ(&format_to_write(folder.file("b.csv"), formats), format_catalogue().front());
}

TEST(PlainValue, DecimalsComeBackAsTheyWereWritten) {
  std::mt19937_64 random(5);
  for (const char* text : {"deg/h", "deg/s", "g", "ug", "degC", "arcsec", "ppm", "deg/sqrt(h)", "ms"}) {
    const Unit unit = Unit::parse(text);
    for (int i = 0; i < 20000; ++i) {
      const int digits = 1 + static_cast<int>(random() % 15);
      const int places = unit.offset() != 0.0 ? digits % 10 : digits - 5;  // an offset costs the digits below 1e-12
      double magnitude = std::pow(10.0, digits);
      if (unit.offset() != 0.0) magnitude = std::pow(10.0, places + 2);
      const double whole = std::floor(std::uniform_real_distribution<>(-magnitude, magnitude)(random));
      const double written = std::stod(std::to_string(static_cast<long long>(whole)) + "e" + std::to_string(-places));
      EXPECT_EQ(file::plain_value(unit.to_si(written), unit), written) << text << " " << written;
    }
  }
}

TEST(PlainValue, ConvertsBackWhereAnyDoubleDoes) {
  std::mt19937_64 random(6);
  for (const char* text : {"deg/h", "g", "degC", "arcsec", "ms"}) {
    const Unit unit = Unit::parse(text);
    for (int i = 0; i < 100000; ++i) {
      const double si = unit.to_si(std::normal_distribution<>(0.0, 100.0)(random));
      EXPECT_EQ(unit.to_si(file::plain_value(si, unit)), si) << text;
    }
  }
}

}  // namespace
}  // namespace tumble
