#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "tumble/formats/testing/reference_texts.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

/// One member of gzip.
std::string packed(const std::string& text) {
  z_stream stream{};
  if (deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib");
  std::string bytes(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // NOLINT: zlib's type
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());  // NOLINT: zlib's type
  stream.avail_out = static_cast<uInt>(bytes.size());
  deflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  return bytes;
}

TEST(Gzip, ReadsWhatWasPacked) {
  const auto recording = read_recording(reference_text("plain.csv.gz"), {}, {});
  EXPECT_EQ(recording.channels[0].values, ramp(0, 50, Unit::parse("deg/h")));
  EXPECT_EQ(recording.origin.file, reference_text("plain.csv.gz"));
}

TEST(Gzip, MembersOneAfterTheOther) {
  EXPECT_TRUE(refusal_of(packed("time[s],a[1]\n0,1\n") + packed("1,2\n2,3\n"), "a.csv.gz").empty());
}

TEST(Gzip, StreamsInBlocks) {
  const std::string path = reference_text("plain.csv.gz");
  std::size_t samples = 0;
  stream_recording(format_of(path), path, {}, 10,
                   [&](const Recording& block) {
                     EXPECT_EQ(block.origin.file, path);
                     samples += block.channels[0].values.size();
                   },
                   {});
  EXPECT_EQ(samples, 50u);
  EXPECT_GT(recording_memory(format_of(path), path, {}), 300u);
}

/// Who asked for the memory first reads the copy that was made for it, unless the file is another one by then.
TEST(Gzip, ACopyIsUsedUntilTheFileChanges) {
  const ScratchFolder folder;
  const std::string path = folder.file("x.csv.gz");
  const auto write = [&](const std::string& text) { std::ofstream(path, std::ios::binary) << packed(text); };
  for (const char* text : {"time[s],a[1]\n0,1\n1,2\n", "time[s],a[1]\n0,1\n1,2\n2,7\n3,8\n"}) {
    write(text);
    const auto samples = static_cast<std::size_t>(std::count(text, text + std::string(text).size(), '\n') - 1);
    EXPECT_GT(recording_memory(format_of(path), path, {}), 0u);
    EXPECT_EQ(read_recording(path, {}, {}).channels[0].values.size(), samples);
    EXPECT_EQ(read_recording(path, {}, {}).channels[0].values.size(), samples);
  }
}

TEST(Gzip, AMessageNamesTheFileInside) {
  const auto refused = refusal_of(packed("time[s],a[dge/h]\n0,1\n"), "x.csv.gz");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"dge"}, .part = "x.csv.gz: x.csv"}, refused));
}

TEST(Gzip, CutAnywhereItIsRefused) { EXPECT_EQ(beginnings_read(reference_text("plain.csv.gz"), 1), 0u); }

TEST(Gzip, WhatUnpacksToMuchMoreThanSamplesDoIsRefused) {
  const auto asks = [](const Asked& asked, const std::string& bytes, const char* name) {
    return refuses(Error::Kind::bad_file, asked, refusal_of(bytes, name));
  };
  EXPECT_TRUE(asks({.values = {"100"}}, packed(std::string(std::size_t{80} << 20, '0')), "bomb.gz"));
  EXPECT_TRUE(asks({.pattern = "packed file in a packed file"}, packed(packed("time[s],a[1]\n0,1\n")), "a.gz.gz"));
  EXPECT_TRUE(asks({.part = "a.tar.gz", .pattern = "tar archive"},
                   packed(std::string(257, 'x') + "ustar" + std::string(300, '\0')), "a.tar.gz"));
}

}  // namespace
}  // namespace tumble
