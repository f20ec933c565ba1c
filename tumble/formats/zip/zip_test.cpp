#include <gtest/gtest.h>
#include <zlib.h>

#include "tumble/formats/testing/reference_texts.hpp"

namespace tumble {
namespace {

TEST(Zip, OneFileIsReadAsIfItWereNotPacked) {
  const auto recording = read_recording(reference_text("one.zip"), {}, {});
  EXPECT_EQ(recording.channels[0].values, ramp(0, 50, Unit::parse("deg/h")));
  EXPECT_EQ(recording.origin.file, reference_text("one.zip"));
  EXPECT_EQ(sha256_of(recording.origin).size(), 64u);
}

TEST(Zip, OfSeveralFilesOneIsPicked) {
  const std::string bytes = read_text_file(reference_text("two.zip"));
  const auto refused = refusal_of(bytes, "two.zip");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {"2", "a.csv"}, .part = "b.csv"}, refused));
  ReadOptions options;
  options.topics = {"b.csv"};
  EXPECT_EQ(read_recording(reference_text("two.zip"), options, {}).channels[0].name, "b");
  options.topics = {"c.csv"};
  EXPECT_TRUE(
      refuses(Error::Kind::bad_file, Asked{.values = {"c.csv", "2", "a.csv"}}, refusal_of(bytes, "two.zip", options)));
}

TEST(Zip, ACommentMayHoldAnything) {
  std::string bytes = read_text_file(reference_text("one.zip"));
  const std::string comment = std::string("PK\5\6") + "of the laboratory, longer than the record at the end";
  bytes[bytes.size() - 2] = static_cast<char>(comment.size());
  EXPECT_TRUE(refusal_of(bytes + comment, "a.zip").empty());
  EXPECT_TRUE(refusal_of(read_text_file(reference_text("one.zip")) + "appended", "a.zip").empty());
}

TEST(Zip, CutAnywhereItIsRefused) { EXPECT_EQ(beginnings_read(reference_text("one.zip"), 1), 0u); }

TEST(Zip, DamagedBytesDoNotAgreeWithTheirChecksum) {
  std::string bytes = read_text_file(reference_text("one.zip"));
  bytes[bytes.find("0.05,")] = '7';
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "checksum"}, refusal_of(bytes, "a.zip")));
}

TEST(Zip, AMessageNamesTheFileInside) {
  std::string bytes = read_text_file(reference_text("one.zip"));
  bytes.replace(bytes.find("a[deg/h]"), 8, "a[dge/h]");
  const auto refused = refusal_of(bytes, "a.zip");  // before anything is read
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "checksum"}, refused));
}

}  // namespace
}  // namespace tumble
