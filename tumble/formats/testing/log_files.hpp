#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {

inline void write_bytes(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// The sentences of all findings of that code.
inline std::string said(const Findings& findings, std::string_view code) {
  std::string text;
  for (const Finding& finding : findings)
    if (finding.code == code) text += finding.message + "\n";
  return text;
}

/// How reading is refused; empty where the file is read.
inline Refused refusal_of(const std::string& path, const ReadOptions& options = {}) {
  return refusal_of([&] { read_recording(path, options, {}); });
}

/// Every file that is cut off is read, with samples that are the first of the whole, or refused with a message.
inline void expect_prefixes(const std::string& bytes, const ReadOptions& options = {}) {
  const ScratchFolder folder;
  const std::string path = folder.file("cut");
  write_bytes(path, bytes);
  const Recording whole = read_recording(path, options, {});
  for (std::size_t size = 1; size < bytes.size(); size += size < 200 ? 1 : 7) {
    write_bytes(path, std::string_view(bytes).substr(0, size));
    try {
      const Recording cut = read_recording(path, options, {});
      for (const Channel& channel : cut.channels) {
        const Channel* all = find_channel(whole, channel.name);
        ASSERT_NE(all, nullptr) << channel.name << " at " << size;
        ASSERT_LE(channel.values.size(), all->values.size()) << size;
        for (std::size_t i = 0; i < channel.values.size(); ++i)
          ASSERT_EQ(channel.values[i], all->values[i]) << channel.name << " at " << size;
      }
    } catch (const Error& error) {
      ASSERT_EQ(error.kind, Error::Kind::bad_file) << size << " " << error.what();
      ASSERT_NE(std::string(error.what()).find("cut"), std::string::npos) << error.what();
    }
  }
}

/// Blocks hold together what reading gives.
inline void expect_streams_the_same(const std::string& path, const ReadOptions& options, std::size_t samples) {
  const Recording whole = read_recording(path, options, {});
  std::vector<std::vector<double>> values(whole.channels.size()), stamps(whole.channels.size());
  std::size_t blocks = 0, findings = 0;
  const auto take = [&](const Recording& block) {
    ++blocks;
    findings += block.findings.size();
    ASSERT_EQ(block.channels.size(), whole.channels.size());
    for (std::size_t i = 0; i < block.channels.size(); ++i)
      for (std::size_t k = 0; k < block.channels[i].values.size(); ++k) {
        values[i].push_back(block.channels[i].values[k]);
        stamps[i].push_back(block.channels[i].time(k));
      }
  };
  stream_recording(format_of(path), path, options, samples, take, {});
  EXPECT_GT(blocks, 1u);
  EXPECT_EQ(findings, whole.findings.size());
  for (std::size_t i = 0; i < whole.channels.size(); ++i) {
    EXPECT_EQ(values[i], whole.channels[i].values) << whole.channels[i].name;
    for (std::size_t k = 0; k < stamps[i].size(); ++k) EXPECT_NEAR(stamps[i][k], whole.channels[i].time(k), 1e-12);
  }
}

}  // namespace tumble
