#include <gtest/gtest.h>

#include "tumble/formats/testing/text_table.hpp"

namespace tumble {
namespace {

struct CsvEpochs : TextTable {};

/// 3904531471 s are 2027-09-23 by the clock of LabVIEW, and 2093-09-23 by Unix time.
TEST_F(CsvEpochs, SecondsSince1904AreNoUnixTime) {
  const auto recording = read("Timestamp\ta[1]\n3904531471.100\t1\n3904531471.200\t2\n3904531471.300\t3\n");
  EXPECT_EQ(recording.channels[0].timeline.rate, 10.0);
  EXPECT_EQ(recording.meta.at("clock_start"), "2027-09-23T08:04:31.1Z");
  expect_holds(said(recording.findings, "clock_recognised"), {"'Timestamp'", "seconds since 1904"});
  const auto before = read("Timestamp\ta[1]\n3499999999\t1\n3500000000\t2\n");
  EXPECT_EQ(before.meta.at("clock_start").substr(0, 4), "2080");
}

}  // namespace
}  // namespace tumble
