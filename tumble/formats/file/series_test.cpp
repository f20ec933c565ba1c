#include "tumble/formats/file/series.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tumble/formats/file/gathered.hpp"

namespace tumble::file {
namespace {

TEST(Series, InASpoolHoldsWhatInMemoryHolds) {
  const auto spool = std::make_shared<Spool>("a test");
  Series memory, spooled(spool), other(spool);
  for (int k = 0; k < 5000; ++k) {
    memory.add(k);
    spooled.add(k);
    const double three[] = {-1.0 * k, -2.0 * k, -3.0 * k};
    other.add(three, 3);  // the chunks of both alternate in the file
  }
  for (const Series* series : {&memory, &spooled}) {
    std::vector<double> part;
    EXPECT_EQ(series->size(), 5000u);
    EXPECT_EQ(series->at(0), 0.0);
    EXPECT_EQ(series->at(1023), 1023.0);
    EXPECT_EQ(series->at(4999), 4999.0);
    series->read(1000, 4000, part);
    ASSERT_EQ(part.size(), 4000u);
    for (std::size_t k = 0; k < part.size(); ++k) ASSERT_EQ(part[k], static_cast<double>(k + 1000));
  }
  EXPECT_EQ(other.at(14'999), -3.0 * 4999);
  EXPECT_EQ(spooled.take(), memory.take());
  EXPECT_EQ(spooled.size(), 0u);
}

TEST(Series, CountsInfiniteValues) {
  Series series;
  const double some[] = {1.0, std::numeric_limits<double>::infinity(), std::nan(""), 2.0};
  series.add(some, 4);
  series.add(-std::numeric_limits<double>::infinity());
  EXPECT_EQ(series.infinite(), 2u);
}

/// Channels of 5000 and 50 samples, the second with uneven stamps in ms.
Gathered two_channels(const std::shared_ptr<Spool>& spool) {
  Gathered gathered;
  const auto fast = std::make_shared<Series>(spool), slow = std::make_shared<Series>(spool),
             stamps = std::make_shared<Series>(spool);
  for (int k = 0; k < 5000; ++k) fast->add(k == 17 ? std::numeric_limits<double>::infinity() : k);
  for (int k = 0; k < 50; ++k) {
    slow->add(0.5 * k);
    stamps->add(1000.0 * k + k % 3);
  }
  gathered.frame.channels = {{"fast", QuantityKind::other, Unit::parse("m"), {0.0, 100.0, nullptr}, {}},
                             {"slow", QuantityKind::temperature, Unit::parse("degC"), {}, {}}};
  gathered.sources = {{fast, nullptr}, {slow, stamps, 1e-3, 2.0}};
  return gathered;
}

TEST(Gathered, BlocksJoinToTheWhole) {
  const Recording whole = in_memory(two_channels(nullptr));
  EXPECT_TRUE(std::isnan(whole.channels[0].values[17]));
  EXPECT_EQ(whole.channels[1].values[3], 1.5 + 273.15);
  EXPECT_EQ(whole.channels[1].time(4), 1e-3 * 4001.0 + 2.0);
  std::vector<std::size_t> count(2);
  std::size_t blocks = 0;
  hand_out(two_channels(std::make_shared<Spool>("a test")), 700,
           [&](const Recording& block) {
             ++blocks;
             for (std::size_t i = 0; i < 2; ++i)
               for (std::size_t k = 0; k < block.channels[i].values.size(); ++k, ++count[i]) {
                 const double expected = whole.channels[i].values[count[i]];
                 EXPECT_TRUE(block.channels[i].values[k] == expected || std::isnan(expected));
                 EXPECT_NEAR(block.channels[i].time(k), whole.channels[i].time(count[i]), 1e-12);
               }
           },
           {});
  EXPECT_EQ(blocks, 8u);  // 5000 samples, up to 700 in each
  EXPECT_EQ(count, (std::vector<std::size_t>{5000, 50}));
}

}  // namespace
}  // namespace tumble::file
