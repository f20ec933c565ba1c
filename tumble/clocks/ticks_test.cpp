#include "tumble/clocks/ticks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tumble/clocks/clock.hpp"
#include "tumble/math/random.hpp"

namespace tumble {
namespace {

enum class Rounding { nearest, down, up };

/// Samples of an even clock of which some are lost, and the stamps that a clock of whole ticks gives them.
struct RoundedRecord {
  double tick = 1.0, interval = 1.0;  ///< [s], [tick]
  std::size_t count = 20'000, losses = 0;
  double start = 0.0;  ///< [s]
  Rounding rounding = Rounding::nearest;

  std::vector<double> stamps() const {
    const RandomStream random(static_cast<std::uint64_t>(1e6 * interval) + losses);
    std::vector<bool> lost(count, false);
    for (std::size_t k = 0; k < losses; ++k)
      lost[1 + static_cast<std::size_t>(random.uniform(k) * static_cast<double>(count - 2))] = true;
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
      const double exact = 0.31 + static_cast<double>(i) * interval;
      const double whole = rounding == Rounding::nearest ? std::round(exact)
                           : rounding == Rounding::down  ? std::floor(exact)
                                                         : std::ceil(exact);
      if (!lost[i]) result.push_back(start + whole * tick);
    }
    return result;
  }
};

Channel channel_at(std::vector<double> stamps, double stated = 0.0) {
  Channel channel;
  channel.values.resize(stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) channel.values[i] = static_cast<double>(i % 97);
  channel.timeline.rate = stated;
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  return channel;
}

std::size_t lost_by(const Clock& clock) {
  std::size_t lost = 0;
  for (const auto& gap : clock.gaps) lost += gap.lost;
  return lost;
}

/// The rate is that of the samples to a tick in the whole record, and each lost sample is found.
void expect_found(const RoundedRecord& record) {
  const auto stamps = record.stamps();
  const Clock clock = clock_of(channel_at(stamps));
  const std::string where = "tick " + std::to_string(record.tick) + " s, interval " + std::to_string(record.interval) +
                            " ticks, from " + std::to_string(record.start) + " s, " + std::to_string(record.losses) +
                            " lost, rounding " + std::to_string(static_cast<int>(record.rounding));
  EXPECT_EQ(lost_by(clock), record.count - stamps.size()) << where;
  const double ticks = record.interval * static_cast<double>(record.count);
  EXPECT_NEAR(clock.rate * record.tick * record.interval, 1.0, 1.0 / ticks) << where;
  EXPECT_EQ(clock.even, record.losses == 0) << where << ": " << clock.reason;
}

// 1 us to 1 s; at Unix time a double has steps of 2.4e-7 s, more than a tick of 1 us can bear.
TEST(Ticks, RoundedStampsOfAnEvenClockAreEven) {
  for (const double tick : {1e-6, 1e-3, 1e-2, 1.0 / 64.0, 1.0})
    for (const double interval : {0.9, 0.97, 0.99, 0.997, 0.999, 1.0007, 1.003009, 1.005, 1.01, 1.04, 1.3, 2.5, 3.7})
      for (const double start : {0.0, 1.7e9})
        for (const Rounding rounding : {Rounding::nearest, Rounding::down, Rounding::up})
          if (start == 0.0 || tick > 1e-5) expect_found({tick, interval, 20'000, 0, start, rounding});
}

// Where a clock slips by a tick every few hundred samples, a sample that is lost is a slip out of the regular
// distances.
TEST(Ticks, LostSamplesAmongRoundedStampsAreFound) {
  for (const double tick : {1e-3, 1.0 / 64.0})
    for (const double interval : {0.97, 0.99, 1.003009, 1.005, 1.01, 1.04, 1.3, 2.5})
      for (const double start : {0.0, 1.7e9})
        for (const Rounding rounding : {Rounding::nearest, Rounding::down, Rounding::up})
          for (const std::size_t losses : {1u, 7u}) expect_found({tick, interval, 20'000, losses, start, rounding});
}

TEST(Ticks, OneLostSampleOfALongRecordIsOneGap) {
  const RoundedRecord record{1e-3, 1.0 / 0.997, 100'000, 1, 0.0, Rounding::nearest};
  const Clock clock = clock_of(channel_at(record.stamps()));
  EXPECT_EQ(clock.reason, "1 sample lost in 1 gap");
  EXPECT_NEAR(clock.rate, 997.0, 997.0 * 1e-5);
}

/// Like expect_found(), with the greatest share of lost samples that the record may still be told from.
void expect_found_about(const RoundedRecord& record) {
  const auto stamps = record.stamps();
  const Clock clock = clock_of(channel_at(stamps));
  const auto lost = static_cast<double>(record.count - stamps.size());
  // a sample that is lost at either end of a doubled tick cannot be told from the other
  EXPECT_NEAR(static_cast<double>(lost_by(clock)), lost, 2.0) << record.interval;
  EXPECT_NEAR(clock.rate * record.tick * record.interval, 1.0, 3.0 / static_cast<double>(record.count))
      << record.interval;
}

// More samples are lost than ticks left out: no stretch without a loss shows the interval, but the ticks that are left
// out at regular distances, and those that are doubled, do.
TEST(Ticks, AHundredthOfTheSamplesLostDoesNotHideAClockNearTheTick) {
  for (const double interval : {0.993, 0.997, 1.0031, 1.0053, 1.01})
    for (const double start : {0.0, 1.7e9})
      for (const Rounding rounding : {Rounding::nearest, Rounding::down, Rounding::up})
        expect_found_about({1e-3, interval, 20'000, 200, start, rounding});
}

// Samples lost beside doubled ticks do not make an interval of one tick of a shorter one.
TEST(Ticks, ARepeatIsNotALostSampleLess) {
  const RoundedRecord record{1e-2, 0.998, 10'000, 100, 0.0, Rounding::nearest};
  const Clock clock = clock_of(channel_at(record.stamps()));
  EXPECT_NEAR(clock.rate, 100.0 / 0.998, 0.02);
}

// Stamps that scatter by a third of a tick are on no line. That the interval may be another is said.
TEST(Ticks, ScatteredStampsNearTheTickAreSaidToBeUnclear) {
  const RandomStream random(7);
  std::vector<double> stamps;
  for (std::size_t i = 0; i < 20'000; ++i) {
    const double exact = 0.3 + 1.003 * static_cast<double>(i) + 0.6 * (random.uniform(i) - 0.5);
    stamps.push_back(std::max(stamps.empty() ? 0.0 : stamps.back(), 1e-3 * std::round(exact)));
  }
  const Clock clock = clock_of(channel_at(stamps));
  const bool right = std::abs(clock.rate * 1.003e-3 - 1.0) < 1e-4,
             told = std::abs(clock.other_rate * 1.003e-3 - 1.0) < 1e-4;
  EXPECT_TRUE(right || told) << clock.rate << " Hz, " << clock.other_rate << " Hz: " << clock.reason;
}

// A row that is written twice is no repeat of the timer.
TEST(Ticks, RowsWrittenTwiceDoNotHideTheInterval) {
  const RoundedRecord record{1e-3, 1.0031, 20'000, 7, 0.0, Rounding::nearest};
  const auto once = record.stamps();
  Channel channel;
  std::vector<double> stamps;
  for (std::size_t i = 0; i < once.size(); ++i)
    for (std::size_t copy = 0; copy < (i % 500 == 250 ? 2u : 1u); ++copy)
      stamps.push_back(once[i]), channel.values.push_back(static_cast<double>(i % 97));
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  const Clock clock = clock_of(channel);
  EXPECT_EQ(lost_by(clock), record.count - once.size());
  EXPECT_NEAR(clock.rate * 1.0031e-3, 1.0, 1e-4);
}

// Three slips at regular distances: a clock of 3 in 1000 less, or three samples lost.
TEST(Ticks, WhereTheStampsDoNotDecideTheStatedRateDoes) {
  const RoundedRecord record{1e-3, 1.0031, 1000, 0, 0.0, Rounding::nearest};
  const Clock open = clock_of(channel_at(record.stamps()));
  EXPECT_EQ(lost_by(open), 3u);
  EXPECT_NEAR(open.other_rate, 1000.0 / 1.0031, 0.5);
  const Clock slower = clock_of(channel_at(record.stamps(), 1000.0 / 1.0031));
  EXPECT_EQ(lost_by(slower), 0u);
  EXPECT_NEAR(slower.rate, 1000.0 / 1.0031, 0.5);
  EXPECT_EQ(slower.other_rate, 0.0);
  const Clock plain = clock_of(channel_at(record.stamps(), 1000.0));
  EXPECT_EQ(lost_by(plain), 3u);
  EXPECT_EQ(plain.other_rate, 0.0);
}

// No rate explains them better than lost samples do.
TEST(Ticks, SamplesLostAnywhereAreLost) {
  const RoundedRecord record{1e-2, 1.0, 20'000, 30, 0.0, Rounding::nearest};
  const Clock clock = clock_of(channel_at(record.stamps()));
  EXPECT_EQ(lost_by(clock), 20'000 - record.stamps().size());
  EXPECT_EQ(clock.other_rate, 0.0);
  EXPECT_NEAR(clock.rate, 100.0, 1e-9);
}

}  // namespace
}  // namespace tumble
