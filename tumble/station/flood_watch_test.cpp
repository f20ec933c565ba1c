// What explains the bytes of a link, and how long a row may be on its way to the disk.
#include "tumble/station/conduct/flood_watch.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tumble/station/conduct/row_wait.hpp"

namespace tumble {
namespace {

using conduct::FloodWatch;
using conduct::RowWait;
using conduct::WordLimit;

TEST(FloodWatch, TakesWhatIsExplainedForEver) {
  FloodWatch watch(1000.0);
  const std::string bytes(100, 'x');
  for (int i = 0; i < 10000; ++i) EXPECT_EQ(watch.take(bytes, 0.1 * i).size(), 100u);
  EXPECT_FALSE(watch.floods());
}

TEST(FloodWatch, TakesTheLatestPartOfAFloodAfterASecondOfIt) {
  FloodWatch watch(10000.0);
  const std::string bytes = std::string(9000, 'x') + std::string(1000, 'y');
  int pieces = 0;
  for (; !watch.floods(); ++pieces) watch.take(bytes, 0.1 * pieces);  // 100 000 a second
  // Of each piece 1000 bytes are explained in the time before the next: 10 000 are reached with the second.
  EXPECT_EQ(pieces, 2);
  const auto taken = watch.take(bytes, 0.2);
  EXPECT_EQ(taken.size(), 2048u);
  EXPECT_EQ(taken.back(), 'y');
  EXPECT_GT(watch.dropped(), 0u);
}

TEST(FloodWatch, TakesWhatCameWhileNobodyLooked) {
  FloodWatch watch(1000.0);
  watch.take("x", 0.0);
  watch.overslept(10.0);
  EXPECT_EQ(watch.take(std::string(10000, 'x'), 10.0).size(), 10000u);
  EXPECT_FALSE(watch.floods());
}

TEST(WordLimit, TellsTheFirstOfASecondAndCountsTheOthers) {
  WordLimit limit;
  int told = 0;
  for (int i = 0; i < 100; ++i) told += limit.allows(5.0) ? 1 : 0;
  EXPECT_EQ(told, 20);
  EXPECT_EQ(limit.take_untold(5.5), 0u);
  EXPECT_EQ(limit.take_untold(6.5), 80u);
  EXPECT_TRUE(limit.allows(6.5));
}

TEST(RowWait, IsOverdueWhenTheDiskHadTheTime) {
  RowWait rows(5.0);
  rows.wrote(7);
  EXPECT_FALSE(rows.look(6, 100.0));
  EXPECT_FALSE(rows.look(6, 160.0)) << "nobody looked for a minute";
  EXPECT_FALSE(rows.is_overdue());
  for (double time = 160.5; time < 165.0; time += 0.5) rows.look(6, time);
  EXPECT_TRUE(rows.is_overdue());
  EXPECT_TRUE(rows.look(7, 165.0));
  EXPECT_EQ(rows.stored(), 1u);
  EXPECT_FALSE(rows.waits());
}

}  // namespace
}  // namespace tumble
