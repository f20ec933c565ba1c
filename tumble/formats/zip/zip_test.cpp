#include <gtest/gtest.h>
#include <zlib.h>

#include "tumble/formats/testing/reference_texts.hpp"

namespace tumble {
namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Zip, OneFileIsReadAsIfItWereNotPacked) {
  const auto recording = read_recording(reference_text("one.zip"), {}, {});
  EXPECT_EQ(recording.channels[0].values, ramp(0, 50, Unit::parse("deg/h")));
  EXPECT_EQ(recording.origin.file, reference_text("one.zip"));
  EXPECT_EQ(sha256_of(recording.origin).size(), 64u);
}

TEST(Zip, OfSeveralFilesOneIsPicked) {
  const std::string bytes = read_text_file(reference_text("two.zip"));
  const auto refused = refusal_of(bytes, "two.zip");
  EXPECT_TRUE(holds(refused, "2 files: 'a.csv', 'b.csv'") && holds(refused, "--topic 'a.csv'")) << refused;
  ReadOptions options;
  options.topics = {"b.csv"};
  EXPECT_EQ(read_recording(reference_text("two.zip"), options, {}).channels[0].name, "b");
  options.topics = {"c.csv"};
  EXPECT_TRUE(holds(refusal_of(bytes, "two.zip", options), "no file 'c.csv'"));
}

TEST(Zip, ACommentMayHoldAnything) {
  std::string bytes = read_text_file(reference_text("one.zip"));
  const std::string comment = std::string("PK\5\6") + "of the laboratory, longer than the record at the end";
  bytes[bytes.size() - 2] = static_cast<char>(comment.size());
  EXPECT_EQ(refusal_of(bytes + comment, "a.zip"), "");
  EXPECT_EQ(refusal_of(read_text_file(reference_text("one.zip")) + "appended", "a.zip"), "");
}

TEST(Zip, CutAnywhereItIsRefused) { EXPECT_EQ(beginnings_read(reference_text("one.zip"), 1), 0u); }

TEST(Zip, DamagedBytesDoNotAgreeWithTheirChecksum) {
  std::string bytes = read_text_file(reference_text("one.zip"));
  bytes[bytes.find("0.05,")] = '7';
  EXPECT_TRUE(holds(refusal_of(bytes, "a.zip"), "do not agree with their checksum"));
}

TEST(Zip, AMessageNamesTheFileInside) {
  std::string bytes = read_text_file(reference_text("one.zip"));
  bytes.replace(bytes.find("a[deg/h]"), 8, "a[dge/h]");
  EXPECT_TRUE(holds(refusal_of(bytes, "a.zip"), "checksum"));  // before anything is read
}

}  // namespace
}  // namespace tumble
