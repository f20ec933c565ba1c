#include "tumble/tasks/long_record.hpp"

#include <gtest/gtest.h>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// A file of 1000 samples at 10 Hz whose clock begins at `begin` [s] and whose date is `date` [s].
RecordPiece piece(const std::string& file, double begin, double date = 0.0) {
  RecordPiece one;
  one.file = file;
  one.clock_start = static_cast<std::int64_t>(date * 1e9);
  one.channels = {{"gyro.x", 1000, 10.0, begin, begin + 99.9}};
  return one;
}

/// Whether the pieces are refused for all of these reasons.
::testing::AssertionResult refuses_pieces(const std::vector<RecordPiece>& pieces, const std::vector<Asked>& all) {
  return refuses(Error::Kind::bad_data, all, [&] { lay_out(pieces); });
}

TEST(RecordLayout, FollowsTheClockFromFileToFile) {
  const auto layout = lay_out({piece("a", 5.0), piece("b", 105.0), piece("c", 305.0)});
  EXPECT_EQ(layout.places[1][0].start, 1000u);
  EXPECT_EQ(layout.places[1][0].lost_before, 0u);
  EXPECT_EQ(layout.places[2][0].lost_before, 1000u);
  for (const auto& places : layout.places) EXPECT_EQ(places[0].total, 4000u);
  ASSERT_EQ(layout.findings.size(), 2u);
  EXPECT_EQ(layout.findings[0].code, "gaps_between_files");
  EXPECT_EQ(layout.findings[1].code, "files_joined_by_clock");
}

TEST(RecordLayout, FollowsDatesBeforeClocks) {
  // Clocks that begin anew; dates that are late by a second, which is the resolution of many loggers, are no gap.
  const auto layout = lay_out({piece("a", 0.0, 1e9), piece("b", 0.0, 1e9 + 101.0), piece("c", 0.0, 1e9 + 301.0)});
  EXPECT_EQ(layout.places[1][0].lost_before, 0u);
  EXPECT_EQ(layout.places[2][0].lost_before, 1000u);
  EXPECT_EQ(layout.findings[1].code, "files_joined_by_dates");
}

TEST(RecordLayout, JoinsFilesWithoutTimes) {
  const auto layout = lay_out({piece("a", 0.0), piece("b", 0.0), piece("c", 0.0, 1e9)});
  EXPECT_EQ(layout.places[2][0].start, 2000u);
  EXPECT_EQ(layout.places[2][0].total, 3000u);
  ASSERT_EQ(layout.findings.size(), 1u);
  EXPECT_EQ(layout.findings[0].code, "files_joined_without_times");
}

TEST(RecordLayout, SaysWhichFilesDoNotFit) {
  auto other = piece("d", 300.0), slow = piece("e", 400.0), wide = piece("f", 500.0);
  other.channels[0].label = "gyro.y";
  slow.channels[0].rate = 5.0;
  wide.channels.push_back(wide.channels[0]);
  EXPECT_TRUE(
      refuses_pieces({piece("a", 0.0), other, slow, wide}, {{.values = {"d"}}, {.values = {"e"}}, {.values = {"f"}}}));
  EXPECT_TRUE(
      refuses_pieces({piece("a", 0.0, 1e9), piece("b", 0.0, 1e9 + 50.0)}, {{.values = {"b"}, .pattern = "begins"}}));
  EXPECT_TRUE(refuses_pieces({piece("a", 0.0), piece("b", 50.0)}, {{.pattern = "each once"}}));
}

TEST(RecordPiece, TravelsAsBytes) {
  RecordPiece one = piece("Größe 陀螺.h5", 5.0, 1e9);
  one.findings = "{}";
  const RecordPiece read = RecordPiece::from_bytes(one.to_bytes());
  EXPECT_EQ(read.file, one.file);
  EXPECT_EQ(read.clock_start, one.clock_start);
  ASSERT_EQ(read.channels.size(), 1u);
  EXPECT_EQ(read.channels[0].samples, 1000u);
  const std::string bytes = one.to_bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.pattern = "ends early"}, [&] {
      RecordPiece::from_bytes(std::string_view(bytes).substr(0, size));
    })) << size;
}

}  // namespace
}  // namespace tumble
