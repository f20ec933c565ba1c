// When samples were taken, where the counter of the instrument and the arrival contradict each other.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tumble/recorder/live_store/sample_clock.hpp"

namespace tumble {
namespace {

using live_store::numbers_of_a_stretch;
using live_store::SampleClock;

struct ArrivedSample {
  std::uint64_t number = 0;
  double taken = 0.0, arrival = 0.0;  ///< [s] when it was complete
};

/// A stream of 50 samples a second for 20 s, whose unit is off from 8 s to 11 s where `off`; samples are up to
/// `latency` [s] late. The number of a sample is `number` of those that were taken before it.
template <class Number>
std::vector<ArrivedSample> stream_of(bool off, double latency, Number number) {
  std::mt19937_64 random(11);
  std::vector<ArrivedSample> samples;
  for (int k = 1; k <= 1000; ++k) {
    const double taken = 0.02 * k;
    if (off && taken > 8.0 && taken < 11.0) continue;
    samples.push_back({number(k), taken, taken + latency * static_cast<double>(random() >> 11) * 0x1p-53});
  }
  return samples;
}

/// [s] by which the even clock is wrong at most; infinity: there is none.
double worst_error(const std::vector<ArrivedSample>& samples, double declared, double modulus) {
  SampleClock clock(declared, modulus);
  for (const auto& one : samples) clock.add(one.number, one.arrival, std::nullopt);
  clock.settle();
  for (const auto& one : samples) clock.place(one.number, one.arrival);
  if (!clock.even()) return HUGE_VAL;
  double worst = 0.0;
  for (const auto& one : samples) {
    const double complete =
        clock.timeline().start + (static_cast<double>(clock.index(one.number)) + 1.0) / clock.rate();
    worst = std::max(worst, std::abs(complete - one.taken));
  }
  return worst;
}

constexpr double interval = 0.02;  // [s]

TEST(SampleClockArrival, AUnitThatWasSwitchedOffCountsAnewAndItsTimeGoesOn) {
  // Numbers by a counter of 8 bits: from 400 mod 256 = 144 back to zero, which looks like 112 frames; 150 were not
  // sent.
  const auto samples =
      stream_of(true, 0.004, [](int k) { return static_cast<std::uint64_t>(k <= 400 ? k : k - 550 + 512); });
  for (const double declared : {50.0, 0.0})
    EXPECT_LT(worst_error(samples, declared, 256.0), 1.5 * interval) << declared;
}

/// Too short to be seen by the arrival alone: the stream says that the counter began again, and not how many frames are
/// missing there. Their number is that of whole intervals, since the latency is shorter than half of one.
TEST(SampleClockArrival, ARestartThatTheStreamHasSeenTakesTheTimeThatItTook) {
  for (const int missing : {0, 1, 7, 25, 300}) {
    std::vector<ArrivedSample> samples;
    for (const ArrivedSample& one : stream_of(false, 0.004, [](int k) { return static_cast<std::uint64_t>(k); })) {
      const auto k = one.number;
      if (k > 400 && k <= 400 + static_cast<std::uint64_t>(missing)) continue;
      samples.push_back(one);
      if (k > 400) samples.back().number = numbers_of_a_stretch + k - static_cast<std::uint64_t>(missing);
      if (k > 800) samples.back().number += numbers_of_a_stretch;  // and again, with no loss
    }
    for (const double declared : {50.0, 0.0})
      EXPECT_LT(worst_error(samples, declared, 4294967296.0), 0.25 * interval) << missing << " of " << declared;
  }
}

TEST(SampleClockArrival, ARestartAmongTheFirstSamplesIsTakenAsCounted) {
  const auto samples =
      stream_of(false, 0.004, [](int k) { return static_cast<std::uint64_t>(k) + (k > 5 ? numbers_of_a_stretch : 0); });
  EXPECT_LT(worst_error(samples, 50.0, 4294967296.0), 0.25 * interval);
}

TEST(SampleClockArrival, RoundsOfACounterThatNobodySawAreFound) {
  const auto samples = stream_of(true, 0.004, [](int k) { return static_cast<std::uint64_t>(k <= 400 ? k : k - 128); });
  EXPECT_LT(worst_error(samples, 50.0, 128.0), 1.5 * interval);
}

TEST(SampleClockArrival, ACounterThatJumpsAheadTakesNoTime) {
  const auto samples =
      stream_of(false, 0.004, [](int k) { return static_cast<std::uint64_t>(k <= 400 ? k : k + 1000); });
  EXPECT_LT(worst_error(samples, 50.0, 65536.0), 1.5 * interval);
}

/// They wait for 5 s, as behind a computer that was busy, and then arrive together, or ten times as fast as usual.
TEST(SampleClockArrival, SamplesThatWaitedKeepTheirTime) {
  for (const double faster : {1e9, 10.0}) {
    auto samples = stream_of(false, 0.004, [](int k) { return static_cast<std::uint64_t>(k); });
    double last = 0.0;
    for (auto& one : samples)
      if (one.taken > 8.0 && one.taken < 13.0)
        last = one.arrival = 13.0 + (one.taken - 8.0) / faster;
      else if (one.arrival < last)
        one.arrival = last = last + interval / faster;
    EXPECT_LT(worst_error(samples, 50.0, 256.0), 0.25 * interval) << faster;
  }
}

/// A process that was stopped for 5 s finds all samples of this time at once: the rate is that of the instrument, for
/// any moment and with or without a declaration. Half of the samples lie on an earliest line of 2 s or more, whose ends
/// are late by up to 4 ms: 0.2 %.
TEST(SampleClockArrival, SamplesThatWaitedDoNotChangeTheRate) {
  for (const double begin : {0.05, 0.3, 1.0, 8.0, 12.0})
    for (const double declared : {50.0, 0.0}) {
      SampleClock clock(declared, 4294967296.0);
      for (const auto& one : stream_of(false, 0.004, [](int k) { return static_cast<std::uint64_t>(k); }))
        clock.add(one.number, one.taken > begin ? std::max(one.arrival, begin + 5.0) : one.arrival, std::nullopt);
      clock.settle();
      EXPECT_NEAR(clock.arrival_rate(), 50.0, 0.002 * 50.0) << begin;
      EXPECT_NEAR(clock.rate(), 50.0, 0.002 * 50.0) << begin;
      EXPECT_EQ(clock.placed(), declared > 0.0);
    }
}

TEST(SampleClockArrival, AWrongDeclarationIsSeenThoughSamplesWaited) {
  SampleClock clock(100.0, 4294967296.0);
  for (const auto& one : stream_of(false, 0.004, [](int k) { return static_cast<std::uint64_t>(k); }))
    clock.add(one.number, one.taken > 8.0 ? std::max(one.arrival, 13.0) : one.arrival, std::nullopt);
  clock.settle();
  EXPECT_FALSE(clock.placed());
  EXPECT_NEAR(clock.rate(), 50.0, 0.002 * 50.0);
}

TEST(SampleClockArrival, JitterOfManyIntervalsChangesNothing) {
  auto samples = stream_of(false, 0.2, [](int k) { return static_cast<std::uint64_t>(k); });
  double last = 0.0, least_late = 1.0;
  for (auto& one : samples) {
    last = one.arrival = std::max(one.arrival, last);  // they arrive in order
    least_late = std::min(least_late, one.arrival - one.taken);
  }
  EXPECT_NEAR(worst_error(samples, 50.0, 256.0), least_late, 1e-9) << "nobody knows how late the least late one is";
}

}  // namespace
}  // namespace tumble
