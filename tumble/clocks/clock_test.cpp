#include "tumble/clocks/clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/math/random.hpp"

namespace tumble {
namespace {

Channel with_stamps(std::vector<double> stamps) {
  Channel channel;
  channel.values.assign(stamps.size(), 0.0);
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  return channel;
}

std::vector<double> even(std::size_t count, double rate, double start = 100.0) {
  std::vector<double> stamps(count);
  for (std::size_t i = 0; i < count; ++i) stamps[i] = start + static_cast<double>(i) / rate;
  return stamps;
}

std::vector<double> without(std::vector<double> stamps, std::size_t first, std::size_t count) {
  stamps.erase(stamps.begin() + static_cast<long>(first), stamps.begin() + static_cast<long>(first + count));
  return stamps;
}

TEST(Clock, UniformChannelIsEven) {
  Channel channel;
  channel.values.assign(10, 0.0);
  channel.timeline.rate = 50.0;
  const Clock clock = clock_of(channel);
  EXPECT_TRUE(clock.even);
  EXPECT_EQ(clock.rate, 50.0);
}

// Stamps of 1e3 s carry rounding of 1e-13 s; of a million samples, 1e-9 relative is ample.
TEST(Clock, EvenStamps) {
  for (const std::size_t count : {3u, 10u, 100u, 1'000u, 100'000u}) {
    const Clock clock = clock_of(with_stamps(even(count, 400.0)));
    EXPECT_TRUE(clock.even) << clock.reason;
    EXPECT_NEAR(clock.rate, 400.0, 400.0 * 1e-9);
    EXPECT_LT(clock.worst, 1e-12);
  }
}

/// Stamps at 10 Hz of which this share is lost at random, with a jitter of this sd [s].
std::vector<double> with_losses(std::size_t count, double share, double jitter, std::size_t& lost) {
  const RandomStream random(71);
  std::vector<double> stamps;
  const auto full = even(count, 10.0);
  for (std::size_t i = 0; i < count; ++i)
    if (i == 0 || i + 1 == count || random.split("loss").uniform(i) >= share)
      stamps.push_back(full[i] + jitter * random.split("jitter").normal(i));
  lost = count - stamps.size();
  return stamps;
}

std::size_t lost_of(const Clock& clock) {
  std::size_t lost = 0;
  for (const auto& gap : clock.gaps) lost += gap.lost;
  return lost;
}

// The sd of a line's slope, jitter/sqrt(n^3/12) = 1.1e-7 s of an interval of 0.1 s; 4 of them.
TEST(Clock, SamplesLostAmongJitterAreCounted) {
  std::size_t lost = 0;
  const Clock clock = clock_of(with_stamps(with_losses(4'000, 0.02, 8e-3, lost)));
  EXPECT_EQ(lost_of(clock), lost);
  EXPECT_NEAR(clock.rate, 10.0, 10.0 * 4.5e-6);
}

TEST(Clock, AThirdOfTheSamplesMayBeLost) {
  std::size_t lost = 0;
  const Clock clock = clock_of(with_stamps(with_losses(4'000, 0.33, 0.0, lost)));
  EXPECT_EQ(lost_of(clock), lost);
  EXPECT_NEAR(clock.rate, 10.0, 1e-8);
}

TEST(Clock, ALoggerThatWasStartedAgainKeepsItsRate) {
  auto stamps = even(4'000, 10.0);
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const std::size_t starts = i / 500;
    stamps[i] += 0.337 * static_cast<double>(starts);
  }
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_EQ(clock.gaps.size(), 7u);
  EXPECT_NEAR(clock.rate, 10.0, 1e-8);
}

TEST(Clock, RoundedStampsAreEven) {
  auto stamps = even(20'000, 300.0);
  for (double& t : stamps) t = std::round(t * 1000.0) / 1000.0;
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_TRUE(clock.even) << clock.reason;
  EXPECT_NEAR(clock.jitter_rms, 1e-3 * std::sqrt(2.0 / 27.0), 1e-7);  // departures of 0, 1/3 and -1/3 count
  EXPECT_NEAR(clock.rate, 300.0, 1e-3);
}

/// Samples at `rate`, of which a share is lost at random, with stamps that a clock of this tick [s] gives.
std::vector<double> ticking(std::size_t count, double rate, double tick, double share, double phase,
                            std::size_t& lost) {
  const RandomStream random(static_cast<std::uint64_t>(1e6 * tick + 1e3 * rate));
  std::vector<double> stamps;
  for (std::size_t i = 0; i < count; ++i)
    if (i == 0 || i + 1 == count || random.uniform(i) >= share)
      stamps.push_back(tick * std::floor((static_cast<double>(i) / rate + phase) / tick));
  lost = count - stamps.size();
  return stamps;
}

std::size_t lost_in(const Clock& clock) {
  std::size_t lost = 0;
  for (const auto& gap : clock.gaps) lost += gap.lost;
  return lost;
}

// 60 Hz by a timer of 1/64 s: neighbours are one tick apart or two, as if a third of the samples were lost.
TEST(Clock, CoarseTicksAreNoLosses) {
  for (const double share_of_interval : {0.3, 0.4, 0.44, 0.48, 0.6, 2.0 / 3.0, 0.7, 0.75, 0.8, 0.9, 0.9375, 0.96})
    for (const double rate : {10.0, 60.0, 133.0})
      for (const double phase : {0.00031, 0.00123}) {  // not on a tick, where rounding decides
        std::size_t lost = 0;
        const Clock clock = clock_of(with_stamps(ticking(6000, rate, share_of_interval / rate, 0.0, phase, lost)));
        EXPECT_NEAR(clock.rate / rate, 1.0, 1e-5) << share_of_interval << " " << rate;
        EXPECT_TRUE(clock.gaps.empty()) << share_of_interval << " " << rate << " " << clock.reason;
        EXPECT_TRUE(clock.even) << share_of_interval << " " << rate << " " << clock.reason;
      }
}

TEST(Clock, LossesAmongCoarseTicksAreCounted) {
  for (const double share_of_interval : {0.3, 0.4, 0.48, 2.0 / 3.0, 0.7, 0.75, 0.9, 0.9375})
    for (const double share : {0.0002, 0.002, 0.01, 0.03}) {
      // 15 samples sweep through a tick that is near the interval: with a loss in most sweeps the two look alike
      if (share_of_interval > 0.93 && share > 0.02) continue;
      std::size_t lost = 0;
      const Clock clock = clock_of(with_stamps(ticking(20000, 60.0, share_of_interval / 60.0, share, 0.001, lost)));
      EXPECT_NEAR(clock.rate / 60.0, 1.0, 1e-5) << share_of_interval << " " << share;
      EXPECT_EQ(lost_in(clock), lost) << share_of_interval << " " << share;
    }
}

TEST(Clock, ASingleLostSampleIsAGap) {
  for (const std::size_t count : {12u, 100u, 10'000u}) {
    const Clock clock = clock_of(with_stamps(without(even(count, 100.0), count / 2, 1)));
    EXPECT_FALSE(clock.even);
    ASSERT_EQ(clock.gaps.size(), 1u) << count;
    EXPECT_EQ(clock.gaps[0].lost, 1u);
    EXPECT_EQ(clock.gaps[0].after, count / 2 - 1);
    EXPECT_NEAR(clock.rate, 100.0, 1e-6);
    EXPECT_LT(clock.worst, 1e-9);  // the gap is taken out
  }
}

TEST(Clock, AStampWrittenTwiceIsNoGap) {
  auto stamps = even(2000, 10.0);
  for (const std::size_t i : {300u, 900u, 1500u}) stamps[i] = stamps[i - 1];
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_EQ(clock.duplicates, 3u);
  EXPECT_TRUE(clock.gaps.empty()) << clock.reason;
  EXPECT_NEAR(clock.rate, 10.0, 1e-4);
  stamps = without(stamps, 1200, 4);
  EXPECT_EQ(lost_in(clock_of(with_stamps(stamps))), 4u);
}

TEST(Clock, SeveralGaps) {
  auto stamps = without(even(10'000, 100.0), 7000, 3);
  stamps = without(without(std::move(stamps), 5000, 31), 100, 500);
  const Clock clock = clock_of(with_stamps(stamps));
  ASSERT_EQ(clock.gaps.size(), 3u);
  EXPECT_EQ(clock.gaps[0].lost, 500u);
  EXPECT_EQ(clock.gaps[1].lost, 31u);
  EXPECT_EQ(clock.gaps[2].lost, 3u);
  EXPECT_EQ(clock.reason, "534 samples lost in 3 gaps");
}

/// Samples that arrive in bursts: each waits until the next multiple of `tick`.
std::vector<double> in_bursts(std::vector<double> stamps, double tick) {
  double last = 0.0;
  for (double& t : stamps) t = last = std::max(last + 1e-4, std::ceil(t / tick) * tick);
  return stamps;
}

TEST(Clock, BurstsOfAnEvenClockAreEven) {
  auto stamps = in_bursts(even(20'000, 100.0), 0.08);
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_TRUE(clock.even) << clock.reason;
  EXPECT_TRUE(clock.gaps.empty());
  EXPECT_NEAR(clock.rate, 100.0, 1e-3);
  EXPECT_GT(clock.jitter_rms, 0.01);
}

TEST(Clock, AStallWithEverySampleDeliveredIsNoGap) {
  auto stamps = in_bursts(even(20'000, 100.0), 0.08);
  for (std::size_t i = 9000; i < 9060; ++i)
    stamps[i] = std::max(stamps[i], stamps[9060] - 0.001 * (9060.0 - static_cast<double>(i)));
  const Clock stalled = clock_of(with_stamps(stamps));
  EXPECT_TRUE(stalled.even) << stalled.reason;
  EXPECT_GT(stalled.longest_pause, 0.5);
  const Clock lost = clock_of(with_stamps(without(stamps, 9000, 60)));
  std::size_t total = 0;  // the last sample of the burst before may be told apart or not
  for (const auto& gap : lost.gaps) total += gap.lost;
  EXPECT_NEAR(static_cast<double>(total), 60.0, 1.0);
  EXPECT_LE(lost.gaps.size(), 2u);
}

// A table that is turned between readings: the pauses are real, nothing comes through afterwards.
TEST(Clock, RegularPausesAreGaps) {
  std::vector<double> stamps{0.0};
  for (int i = 1; i < 150; ++i) stamps.push_back(stamps.back() + (i % 6 == 0 ? 16.3 : 6.55));
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_FALSE(clock.even) << clock.reason;
  EXPECT_EQ(clock.gaps.size(), 24u);
}

TEST(Clock, IrregularSamplesAreNotEven) {
  const RandomStream random(11);
  std::vector<double> stamps{0.0};
  for (std::size_t i = 0; i < 20'000; ++i) stamps.push_back(stamps.back() - 0.01 * std::log(random.uniform(i)));
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_FALSE(clock.even);
}

TEST(Clock, AChangeOfRateIsNotEven) {
  auto stamps = even(5000, 100.0);
  for (std::size_t i = 0; i < 5000; ++i) stamps.push_back(stamps.back() + 0.02);
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_FALSE(clock.even) << clock.reason;
}

TEST(Clock, BackwardAndDuplicateStamps) {
  auto stamps = even(1000, 100.0);
  stamps[500] = stamps[499];
  stamps[700] = stamps[698];
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_EQ(clock.duplicates, 1u);
  EXPECT_EQ(clock.backward, 1u);
  EXPECT_EQ(clock.first_backward, 700u);
  EXPECT_FALSE(clock.even);
}

TEST(Clock, HostileStamps) {
  for (const auto& stamps : std::vector<std::vector<double>>{{},
                                                             {1},
                                                             {1, 2},
                                                             {1, 1, 1, 1},
                                                             {4, 3, 2, 1},
                                                             {1, NAN, 3, 4},
                                                             {NAN, NAN, NAN},
                                                             {1, 2, INFINITY},
                                                             {0, 1e300, 2e300},
                                                             {-1e308, 0, 1e308}}) {
    const Clock clock = clock_of(with_stamps(stamps));
    EXPECT_FALSE(clock.reason.empty());
  }
}

// 9 minutes of an MPU-6050 whose samples arrive in bursts, with pauses of up to a third of a second after which the
// backlog comes through: nothing is lost. Rate and longest pause are read from the file (examples/data/SOURCE.md).
TEST(Clock, RealBursts) {
  std::ifstream stream(TUMBLE_SOURCE_DIR "/examples/data/mpu6050_static.csv");
  std::string line;
  std::getline(stream, line);
  std::vector<double> stamps;
  while (std::getline(stream, line)) stamps.push_back(std::stod(line));
  ASSERT_EQ(stamps.size(), 53625u);
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_TRUE(clock.even) << clock.reason;
  EXPECT_TRUE(clock.gaps.empty());
  EXPECT_NEAR(clock.rate, 99.317, 0.2);
  EXPECT_NEAR(clock.longest_pause, 0.313, 0.001);
  const Clock lost = clock_of(with_stamps(without(stamps, 30'000, 100)));
  ASSERT_EQ(lost.gaps.size(), 1u);
  EXPECT_NEAR(static_cast<double>(lost.gaps[0].lost), 100.0, 10.0);  // the clock behind the bursts wanders by that
}

TEST(SamplingRate, LostSamplesDoNotChangeIt) {
  std::vector<double> stamps;
  for (int i = 0; i < 5000; ++i)
    if (i < 2000 || i >= 2400) stamps.push_back(0.01 * i);
  Channel channel;
  channel.values.assign(stamps.size(), 0.0);
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
  // The clock is the median of 64 intervals, each a difference of stamps rounded to 1e-15 of 50 s.
  EXPECT_NEAR(sampling_rate(channel), 100.0, 1e-9);
  EXPECT_LT(mean_rate(channel), 93.0);
}

TEST(SampledTogether, ComparesRateBeginAndStamps) {
  Channel uniform;
  uniform.values.assign(3, 0.0);
  uniform.timeline = {5.0, 10.0, nullptr};
  Channel later = uniform, longer = uniform;
  later.timeline.start = 5.1;
  longer.values.push_back(0.0);
  EXPECT_TRUE(sampled_together(uniform, uniform));
  EXPECT_FALSE(sampled_together(uniform, later));
  EXPECT_FALSE(sampled_together(uniform, longer));
  const Channel stamped = with_stamps({5.0, 5.1, 5.2});
  EXPECT_TRUE(sampled_together(stamped, with_stamps({5.0, 5.1, 5.2})));
  EXPECT_FALSE(sampled_together(stamped, with_stamps({5.0, 5.1, 5.3})));
  EXPECT_FALSE(sampled_together(stamped, uniform));
}

// One in a hundred is lost in nearly every part of the record: no part has the mean interval. 4 sd of the slope,
// jitter/sqrt(n^3/12) = 1.0e-8 s of an interval of 0.1 s.
TEST(Clock, OneSampleLostInAHundredIsCounted) {
  std::size_t lost = 0;
  const Clock clock = clock_of(with_stamps(with_losses(10'000, 0.01, 3e-3, lost)));
  EXPECT_EQ(lost_of(clock), lost);
  EXPECT_NEAR(clock.rate, 10.0, 10.0 * 4.2e-7);
}

// Stamps repeat where the timer is coarser than the interval. A tick is 5e-5 of the record, and chance hides a few of
// the losses within it: 2e-5 of the rate is a third of what one loss in 2000 samples changes.
TEST(Clock, SamplesLostUnderATimerLongerThanTheIntervalAreCounted) {
  for (const double rate : {71.3, 93.7, 118.1})
    for (const double share : {0.0, 0.002}) {
      std::size_t lost = 0;
      const Clock clock = clock_of(with_stamps(ticking(20'000, rate, 1.0 / 64.0, share, 0.0, lost)));
      EXPECT_NEAR(clock.rate, rate, 2e-5 * rate) << rate << " Hz, " << share;
      EXPECT_NEAR(static_cast<double>(lost_in(clock)), static_cast<double>(lost), 1.0) << rate << " Hz, " << share;
    }
}

// 20 000 samples with a clock that ticks 1 % faster than they come: every hundredth interval is of two ticks.
TEST(Clock, AnIntervalALittleLongerThanTheTickLosesNothing) {
  std::size_t lost = 0;
  const Clock clock = clock_of(with_stamps(ticking(20'000, 100.0, 9.9e-3, 0.0, 0.0, lost)));
  EXPECT_EQ(lost_in(clock), 0u);
  EXPECT_NEAR(clock.rate, 100.0, 1e-3);
}

TEST(Clock, RowsThatAreWrittenTwiceCountOnce) {
  const RandomStream random(73);
  const auto once = even(20'000, 100.0);
  Channel channel = with_stamps({});
  std::vector<double> stamps;
  for (std::size_t i = 0; i < once.size(); ++i)
    for (int row = 0; row < (random.split("row").uniform(i) < 0.03 ? 2 : 1); ++row) {
      stamps.push_back(once[i]);
      channel.values.push_back(random.split("value").normal(i));
    }
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(stamps);
  const Clock clock = clock_of(channel);
  EXPECT_EQ(clock.duplicates, stamps.size() - once.size());
  EXPECT_NEAR(clock.rate, 100.0, 1e-6);
  EXPECT_TRUE(clock.even) << clock.reason;
}

// 32 samples wait in the sensor, are read at once and stamped as they are read: each burst is no record with gaps. The
// rate is known to a reading in the whole record, 32 of 20 000 samples.
TEST(Clock, ABufferThatIsReadAtOnceLosesNothing) {
  std::vector<double> stamps;
  for (std::size_t i = 0; i < 20'000; ++i) {
    const std::size_t read = 32 * (i / 32 + 1);
    stamps.push_back(0.01 * static_cast<double>(read) + 5e-5 * static_cast<double>(i % 32));
  }
  const Clock clock = clock_of(with_stamps(stamps));
  EXPECT_TRUE(clock.gaps.empty());
  EXPECT_NEAR(clock.rate, 100.0, 100.0 * 32.0 / 20'000.0);
}

}  // namespace
}  // namespace tumble
