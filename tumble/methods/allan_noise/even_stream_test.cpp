// Stamps of recordings that pass by in blocks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "tumble/core/channel.hpp"
#include "tumble/core/settings.hpp"
#include "tumble/methods/allan_noise/stream.hpp"

namespace tumble::allan_noise {
namespace {

/// Counts the samples of an even clock whose stamps are rounded to a tick, block after block.
///
/// Given  interval, tick  [s]
///        lost            numbers of the samples that are missing
Clocked streamed(double interval, double tick, const std::vector<std::size_t>& lost) {
  constexpr std::size_t samples = 120'000, block = 25'000;
  Settings settings;
  settings.set_word("timing", "auto");
  EvenStream stream("gyro", settings);
  std::vector<double> values, stamps;
  const auto hand_over = [&] {
    Channel channel;
    channel.timeline.rate = 0.0;
    channel.timeline.stamps = std::make_shared<const std::vector<double>>(stamps);
    channel.values.assign(stamps.size(), 0.0);
    stream.take(channel, values);
    stamps.clear();
  };
  for (std::size_t i = 0; i < samples; ++i) {
    if (std::ranges::find(lost, i) != lost.end()) continue;
    stamps.push_back(std::round(static_cast<double>(i) * interval / tick) * tick);
    if (stamps.size() == block) hand_over();
  }
  hand_over();
  return stream.clocked();
}

/// The interval is known to one tick over the whole record: 1/120 000 of it.
TEST(EvenStream, StampsOfACoarseClockShowWhatIsLostAndNoMore) {
  const std::vector<std::vector<std::size_t>> losses{{12'345}, {500, 24'999, 25'000, 25'001, 70'000, 119'000}};
  for (const double ratio : {0.994, 1.003, 1.009, 1.37})
    for (const auto& lost : losses) {
      const Clocked clocked = streamed(ratio * 0.01, 0.01, lost);
      EXPECT_EQ(clocked.lost, lost.size()) << ratio;
      EXPECT_NEAR(clocked.rate * ratio * 0.01, 1.0, 1.0 / 120e3) << ratio;
    }
}

}  // namespace
}  // namespace tumble::allan_noise
