#include "tumble/reduce/arrival_stamps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

namespace tumble {
namespace {

/// Samples at 20 Hz from 3 s on that a buffer hands over, so many at a time, each a little after the one before.
Channel in_bursts(std::size_t samples, std::size_t together) {
  Channel channel{"gyro", QuantityKind::angular_rate, Unit::parse("rad/s"), {}, {}};
  auto stamps = std::make_shared<std::vector<double>>();
  for (std::size_t i = 0; i < samples; ++i) {
    const std::size_t last = std::min(samples - 1, i / together * together + together - 1);
    stamps->push_back(3.0 + 0.05 * static_cast<double>(last) + 5e-4 * static_cast<double>(i % together));
    channel.values.push_back(static_cast<double>(i * 37 % 101));
  }
  channel.timeline = {stamps->front(), 0.0, std::move(stamps)};
  return channel;
}

TEST(ArrivalStamps, SamplesOfABufferWereTakenEvenly) {
  for (const std::size_t samples : {1500u, 3001u, 19996u}) {
    const auto clock = timeline_of_bursts(in_bursts(samples, 8));
    ASSERT_TRUE(clock) << samples;
    EXPECT_NEAR(clock->rate, 20.0, 1e-6) << samples;
    EXPECT_NEAR(clock->start, 3.0, 0.005) << "a burst of eight takes 3.5 ms";
  }
}

TEST(ArrivalStamps, StampsThatScatterALittleStayAsTheyAre) {
  EXPECT_FALSE(timeline_of_bursts(in_bursts(3000, 1)));
  Channel even = in_bursts(3000, 8);
  even.timeline = {0.0, 20.0, nullptr};
  EXPECT_FALSE(timeline_of_bursts(even));
}

TEST(ArrivalStamps, ChannelsWithoutBurstsAreNotChanged) {
  Recording recording;
  recording.channels = {in_bursts(3000, 1), in_bursts(3000, 8)};
  EXPECT_FALSE(with_clocks_of_bursts({Recording{}}));
  const auto taken = with_clocks_of_bursts({recording});
  ASSERT_TRUE(taken);
  EXPECT_FALSE((*taken)[0].channels[0].timeline.uniform());
  EXPECT_TRUE((*taken)[0].channels[1].timeline.uniform());
}

}  // namespace
}  // namespace tumble
