// Readers of logs, MATLAB and WAV files on hostile bytes: the reference files, mutated with a fixed seed.
#include <gtest/gtest.h>

#include <random>

#include "fuzz/readers.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

/// Changes, removes, repeats or inserts a few bytes, most of them near the beginning, where sizes and descriptions
/// stand; sometimes cuts the end off.
std::string damaged(std::string bytes, std::mt19937_64& random) {
  const auto at = [&] {
    const std::size_t place = random() % bytes.size();
    return random() % 2 == 0 ? place : place % std::min<std::size_t>(bytes.size(), 600);
  };
  for (auto changes = 1 + random() % 5; changes-- > 0 && !bytes.empty();) {
    switch (random() % 7) {
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
        bytes.replace(at(), 4, 4, static_cast<char>(random() % 2 == 0 ? 0x7f : 0xff));
        break;
      case 4:
        bytes.erase(at(), 1 + random() % 40);
        break;
      case 5: {
        const auto from = at();
        bytes.insert(at(), bytes.substr(from, random() % 80));
        break;
      }
      default:
        if (random() % 4 == 0) bytes.resize(at());
    }
  }
  return bytes;
}

void attack_reference(const std::string& name, std::uint64_t seed, ReadOptions options, int times = 400) {
  const ScratchFolder folder;
  const std::string original = read_text_file(TUMBLE_SOURCE_DIR "/tests/reference/" + name), file = folder.file("f");
  std::mt19937_64 random(seed);
  for (const char* unit : {"gyro", "acc", "temperature", "bias", "imu.gyro", "imu.raw", "data", "channel1", "channel2"})
    options.units[unit] = Unit::parse("g");
  const Format& format = format_of(TUMBLE_SOURCE_DIR "/tests/reference/" + name);
  for (int i = 0; i < times; ++i) {
    fuzz::write_bytes(damaged(original, random), file);
    ASSERT_EQ(fuzz::read_hostile_as(format, file, options, 5), "") << name << ", mutation " << i << " of seed " << seed;
    if (i % 2 == 0) options.rate = options.rate ? std::nullopt : std::optional(100.0);
  }
}

TEST(Fuzz, ULog) {
  attack_reference("ulog/flight.ulg", 21, {});
  attack_reference("ulog/flight.ulg", 22, {.topics = {"sensor_gyro", "esc_status", "sensor_combined"}});
  attack_reference("ulog/bursts.ulg", 23, {});
  attack_reference("ulog/appended.ulg", 24, {});
}

TEST(Fuzz, DataFlash) {
  attack_reference("dataflash/copter.bin", 31, {});
  attack_reference("dataflash/copter.bin", 32, {.topics = {"IMU", "ATT"}});
  attack_reference("dataflash/old.bin", 33, {});
  attack_reference("dataflash/raw.bin", 34, {});
}

TEST(Fuzz, Wav) {
  attack_reference("wav/counts24.wav", 41, {});
  attack_reference("wav/float32.wav", 42, {});
  attack_reference("wav/large.wav", 43, {});
}

TEST(Fuzz, Mat) {
  for (const char* name : {"plain", "packed", "old", "table"})
    attack_reference(std::string("mat/") + name + ".mat", 51, {});
  attack_reference("mat/structure.mat", 52, {.topics = {"imu"}});
  attack_reference("mat/hdf5.mat", 53, {.topics = {"gyro", "imu"}});
}

}  // namespace
}  // namespace tumble
