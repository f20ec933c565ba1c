// Readers on hostile bytes: small valid files, mutated with a fixed seed.
#include <gtest/gtest.h>

#include <random>

#include "fuzz/readers.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

Recording small(bool stamped) {
  Recording recording;
  recording.instrument = "gyro 7";
  recording.marks = {{"static", 0.0, 1}, {"ramp", 0.5, 2}};
  recording.meta = {{"operator", "N. N."}};
  Timeline timeline{0.0, 100.0, nullptr};
  if (stamped) timeline = {0.0, 0.0, std::make_shared<std::vector<double>>()};
  std::vector<double> stamps;
  for (const char* unit : {"deg/h", "degC"}) {
    Channel channel{
        recording.channels.empty() ? "gyro.x" : "temperature", QuantityKind::other, Unit::parse(unit), timeline, {}};
    channel.kind = kind_of(channel.unit);
    for (int i = 0; i < 200; ++i) {
      channel.values.push_back(channel.unit.to_si(0.25 * i - 3));
      if (stamps.size() < 200) stamps.push_back(0.01 * i + (i % 3) * 0.001);
    }
    recording.channels.push_back(channel);
  }
  if (stamped)
    for (Channel& channel : recording.channels)
      channel.timeline.stamps = std::make_shared<const std::vector<double>>(stamps);
  return recording;
}

std::string bytes_of(const Recording& recording, const std::string& path) {
  write_recording(recording, path);
  return read_text_file(path);
}

/// Flips, replaces, inserts, repeats or removes a few bytes; sometimes cuts the end off.
std::string mutated(std::string bytes, std::mt19937_64& random, std::string_view spice) {
  const auto at = [&] { return bytes.empty() ? 0 : random() % bytes.size(); };
  for (auto changes = 1 + random() % 6; changes-- > 0 && !bytes.empty();) {
    switch (random() % 8) {
      case 0:
        bytes[at()] ^= static_cast<char>(1 << random() % 8);
        break;
      case 1:
        bytes[at()] = static_cast<char>(random());
        break;
      case 2:
        bytes[at()] = static_cast<char>(random() % 2 == 0 ? 0 : 0xff);
        break;
      case 3:
        bytes[at()] = spice[random() % spice.size()];
        break;
      case 4:
        bytes.insert(at(), 1, spice[random() % spice.size()]);
        break;
      case 5:
        bytes.erase(at(), 1 + random() % 8);
        break;
      case 6: {
        const auto from = at();
        bytes.insert(at(), bytes.substr(from, random() % 40));
        break;
      }
      default:
        if (random() % 4 == 0) bytes.resize(at());
    }
  }
  return bytes;
}

void attack(const std::string& original, std::uint64_t seed, int times, std::string_view spice) {
  const ScratchFolder folder;
  std::mt19937_64 random(seed);
  ASSERT_EQ(fuzz::read_hostile(original, folder.file("f")), "");
  for (int i = 0; i < times; ++i) {
    const auto wrong = fuzz::read_hostile(mutated(original, random, spice), folder.file("f"));
    ASSERT_EQ(wrong, "") << "mutation " << i << " of seed " << seed;
  }
}

TEST(Fuzz, Csv) {
  const ScratchFolder folder;
  attack(bytes_of(small(false), folder.file("a.csv")), 1, 1000, ",;\t \n\r\"#[]{}.-+eE0129nif:");
  attack(bytes_of(small(true), folder.file("a.csv")), 2, 1000, ",;\t \n\r\"#[]{}.-+eE0129nif:");
  attack("time[s];a[1];b[deg/h]\n0;1,5;2\n1;2,5;\n2;;1\n", 3, 2000, ",;\t \n\r\"#[]{}.-+eE0129nif:");
}

TEST(Fuzz, Hdf5) {
  const ScratchFolder folder;
  attack(bytes_of(small(false), folder.file("a.h5")), 4, 1000, std::string_view("\0\1\2\xff\x80/HDFTREE", 13));
  attack(bytes_of(small(true), folder.file("a.h5")), 5, 1000, std::string_view("\0\1\2\xff\x80/HDFTREE", 13));
}

TEST(Fuzz, Hdf5CutAnywhere) {
  const ScratchFolder folder;
  const auto whole = bytes_of(small(true), folder.file("a.h5"));
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 40)
    ASSERT_EQ(fuzz::read_hostile(whole.substr(0, size), folder.file("f")), "") << size;
}

/// Bytes of the file's structure; those of the samples cannot be told from good ones.
TEST(Fuzz, Hdf5EverySecondByteOfTheFirstPage) {
  const ScratchFolder folder;
  auto bytes = bytes_of(small(true), folder.file("a.h5"));
  for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 4096); at += 2) {
    bytes[at] = static_cast<char>(~bytes[at]);
    ASSERT_EQ(fuzz::read_hostile(bytes, folder.file("f")), "") << at;
    bytes[at] = static_cast<char>(~bytes[at]);
  }
}

TEST(Fuzz, LogsOfRos) {
  std::uint64_t seed = 20;
  for (const char* name : {"lz4.bag", "bz2.bag", "plain.db3", "zstd.mcap", "no_index.mcap", "unchunked.mcap"})
    attack(read_text_file(std::string(TUMBLE_SOURCE_DIR "/tests/reference/ros/") + name), seed++, 150,
           std::string_view("\0\1\2\7\xff\x7f\x80", 7));
}

}  // namespace
}  // namespace tumble
