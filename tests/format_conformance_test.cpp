// What every file format promises: hostile bytes are an Error. One that can be written promises also that it reads back
// bit by bit what it wrote, and that it writes whole files or none.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>

#include "tumble/clocks/clock.hpp"
#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/math/random.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

class Formats : public ::testing::TestWithParam<const Format*> {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("tumble_" + std::string(format().name) + "_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  const Format& format() const { return *GetParam(); }
  std::string path(const std::string& stem) const { return (folder_ / (stem + format().extensions[0])).string(); }
  std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }

  fs::path folder_;
};

class WritableFormats : public Formats {};

FormatList writable_formats() {
  FormatList formats = format_catalogue();
  std::erase_if(formats, [](const Format* format) { return format->writer == nullptr; });
  return formats;
}

/// Two channels at one rate with a missing sample and two marks. The values are what instruments give: numbers with
/// nine digits in the unit of the file. (An arbitrary SI value need not be the image of any number in deg/h.)
Recording sample(std::size_t samples = 100) {
  const RandomStream random(11);
  const auto nine_digits = [](double value) { return std::stod(fmt::format("{:.9g}", value)); };
  const Unit rate = Unit::parse("deg/h"), temperature = Unit::parse("degC");
  Recording recording;
  recording.channels = {{"gyro", QuantityKind::angular_rate, rate, {0.0, 8.0, nullptr}, {}},
                        {"temperature.case", QuantityKind::temperature, temperature, {0.0, 8.0, nullptr}, {}}};
  for (std::size_t i = 0; i < samples; ++i) {
    recording.channels[0].values.push_back(rate.to_si(nine_digits(2.0 * random.normal(i))));
    recording.channels[1].values.push_back(temperature.to_si(nine_digits(20.0 + random.split(1).normal(i))));
  }
  recording.channels[0].values[17] = std::nan("");
  recording.channels[0].values[18] = 0.0;
  recording.marks = {{"first", 0.0, 1}, {"second, with comma", 6.0, 2}};
  return recording;
}

std::string bytes_of(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put(const std::string& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

TEST_P(Formats, ExtensionsAreWhole) {
  ASSERT_FALSE(format().extensions.empty());
  for (const auto& extension : format().extensions) EXPECT_EQ(extension.front(), '.') << extension;
}

TEST_P(WritableFormats, ReadsBackWhatItWrote) {
  const Recording written = sample();
  write_recording(written, path("a"));
  EXPECT_TRUE(format().recognises(path("a")));
  const Recording read = read_recording(path("a"), {}, {});
  EXPECT_EQ(sha256_of(read.origin).size(), 64u);
  ASSERT_EQ(read.marks.size(), written.marks.size());
  for (std::size_t i = 0; i < written.marks.size(); ++i) {
    EXPECT_EQ(read.marks[i].label, written.marks[i].label);
    EXPECT_EQ(read.marks[i].begin, written.marks[i].begin);
    EXPECT_EQ(read.marks[i].run, written.marks[i].run);
  }
  for (const auto& channel : written.channels) {
    const Channel* found = find_channel(read, channel.name);
    ASSERT_NE(found, nullptr) << channel.name;
    EXPECT_EQ(found->unit, channel.unit);
    EXPECT_EQ(found->kind, channel.kind);
    ASSERT_EQ(found->values.size(), channel.values.size());
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      EXPECT_NEAR(found->time(i), channel.time(i), 1e-12);
      EXPECT_EQ(std::isnan(found->values[i]), std::isnan(channel.values[i])) << channel.name << " " << i;
      if (std::isnan(channel.values[i])) continue;
      EXPECT_EQ(found->values[i], channel.values[i]) << channel.name << " " << i;
    }
  }
}

TEST_P(WritableFormats, SameRecordingSameBytes) {
  write_recording(sample(), path("a"));
  write_recording(sample(), path("b"));
  EXPECT_EQ(bytes_of(path("a")), bytes_of(path("b")));
}

TEST_P(WritableFormats, StreamsWhatItReads) {
  write_recording(sample(50000), path("a"));
  std::vector<double> values;
  std::size_t blocks = 0;
  stream_recording(format(), path("a"), {}, 30,
                   [&](const Recording& block) {
                     ++blocks;
                     const Channel* channel = find_channel(block, "temperature.case");
                     ASSERT_NE(channel, nullptr);
                     values.insert(values.end(), channel->values.begin(), channel->values.end());
                   },
                   {});
  EXPECT_GT(blocks, 1u);
  EXPECT_EQ(values, find_channel(read_recording(path("a"), {}, {}), "temperature.case")->values);
}

// 99.7 Hz with stamps of two digits: none is lost, by whatever file the stamps come. Half a tick at either end of 20
// 000 samples is 5e-5 of the rate.
TEST_P(WritableFormats, RoundedStampsOfAnEvenClockAreEven) {
  Recording rounded = sample(20'000);
  std::vector<double> stamps;
  for (int i = 0; i < 20'000; ++i) stamps.push_back(std::round(100.0 * i / 99.7) / 100.0);
  const auto shared = std::make_shared<const std::vector<double>>(stamps);
  for (Channel& channel : rounded.channels) channel.timeline = {0.0, 0.0, shared};
  rounded.marks.clear();
  write_recording(rounded, path("a"));
  const Recording read = read_recording(path("a"), {}, {});
  const Clock clock = clock_of(*find_channel(read, "gyro"));
  EXPECT_TRUE(clock.even) << clock.reason;
  EXPECT_NEAR(clock.rate, 99.7, 99.7 * 5e-5);
  ReadOptions stated;
  stated.rate = 99.7;
  EXPECT_NEAR(sampling_rate(*find_channel(read_recording(path("a"), stated, {}), "gyro")), 99.7, 99.7 * 5e-5);
}

TEST_P(WritableFormats, WithoutCommitNothingRemains) {
  put(path("a"), "what stood there before");
  {
    auto writer = format().writer(path("a"));
    writer.append(sample());
  }
  EXPECT_EQ(bytes_of(path("a")), "what stood there before");
  EXPECT_EQ(files(), 1u);
}

TEST_P(WritableFormats, UnwritableTargetIsBadFile) {
  try {
    write_recording(sample(), (folder_ / "no_such_folder" / ("a" + format().extensions[0])).string());
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::bad_file) << error.what();
  }
}

/// Reads `file`; an Error must name it, and nothing else may be thrown. True where it was an Error.
bool refuses(const Format& format, const std::string& file) {
  try {
    format.read(file, {}, {});
    return false;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(fs::path(file).filename().string()), std::string::npos) << error.what();
    return true;
  }
}

TEST_P(Formats, MissingAndEmptyFilesAreRefused) {
  EXPECT_TRUE(refuses(format(), path("absent")));
  put(path("empty"), "");
  EXPECT_TRUE(refuses(format(), path("empty")));
}

TEST_P(Formats, HostileBytesAreReadOrRefused) {
  if (format().writer) write_recording(sample(), path("a"));
  const RandomStream random(5);
  std::string good = format().writer ? bytes_of(path("a")) : std::string(4096, '\0');
  if (!format().writer)
    for (std::size_t i = 0; i < good.size(); ++i) good[i] = static_cast<char>(256.0 * random.split(999).uniform(i));
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    const auto draw = random.split(trial);
    std::string bad = good;
    if (trial % 3 == 0) bad.resize(static_cast<std::size_t>(draw.uniform(0) * static_cast<double>(good.size())));
    for (std::uint64_t k = 0; k < 1 + trial % 7 && !bad.empty(); ++k) {
      const auto at = static_cast<std::size_t>(draw.uniform(10 + 2 * k) * static_cast<double>(bad.size()));
      bad[at] = static_cast<char>(256.0 * draw.uniform(11 + 2 * k));
    }
    put(path("bad"), bad);
    EXPECT_NO_FATAL_FAILURE(refuses(format(), path("bad"))) << "trial " << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(All, WritableFormats, ::testing::ValuesIn(writable_formats()),
                         [](const auto& entry) { return std::string(entry.param->name); });
INSTANTIATE_TEST_SUITE_P(All, Formats, ::testing::ValuesIn(format_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

TEST(FormatCatalogue, ExtensionsBelongToOneFormat) {
  std::set<std::string> seen;
  for (const auto* format : format_catalogue()) {
    for (const auto& extension : format->extensions) EXPECT_TRUE(seen.insert(extension).second) << extension;
  }
}

}  // namespace
}  // namespace tumble
