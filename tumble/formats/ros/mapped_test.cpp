// Logs that are mapped, and those that are copied because somebody has them open for writing: what is read is the same.

#include <gtest/gtest.h>

#include <fstream>

#include "tumble/formats/testing/log_files.hpp"

namespace tumble {
namespace {

/// Findings, channels and samples as text; or the message with which the file is refused.
std::string content_of(const std::string& path) {
  std::string text;
  try {
    const Recording recording = read_recording(path, {}, {});
    for (const Finding& finding : recording.findings) text += finding.message + "\n";
    for (const Channel& channel : recording.channels) {
      text += channel.name + " " + std::to_string(channel.timeline.rate);
      for (const double value : channel.values) text += " " + std::to_string(value);
    }
    text += sha256_of(recording.origin);
  } catch (const Error& error) {
    text = error.what();
  }
  return text;
}

void expect_the_same(const std::string& path, const std::string& bytes) {
  write_bytes(path, bytes);
  const std::string mapped = content_of(path);
  const std::ofstream writer(path, std::ios::app);
  EXPECT_EQ(mapped, content_of(path)) << bytes.size();
}

TEST(RosMapped, MappedAndCopiedLogsAreReadAlike) {
  const ScratchFolder folder;
  for (const char* name : {"plain.bag", "lz4.bag", "bz2.bag", "plain.mcap", "lz4.mcap", "zstd.mcap", "no_index.mcap",
                           "unchunked.mcap", "ros1.mcap", "plain.db3"}) {
    const std::string whole = read_text_file(std::string(TUMBLE_SOURCE_DIR "/tests/reference/ros/") + name);
    const std::string path = folder.file(name);
    expect_the_same(path, whole);
    std::uint64_t state = 1;
    for (int k = 0; k < 40; ++k) {
      std::string bytes =
          whole.substr(0, whole.size() - (k % 4 == 0 ? whole.size() / 50 * static_cast<std::size_t>(k) / 4 : 0));
      for (int spoiled = 0; spoiled < k % 5; ++spoiled) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        bytes[(state >> 20) % bytes.size()] = static_cast<char>(state >> 56);
      }
      expect_the_same(path, bytes);
    }
  }
}

}  // namespace
}  // namespace tumble
