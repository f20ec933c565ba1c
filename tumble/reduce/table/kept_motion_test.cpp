#include "tumble/reduce/table/kept_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tumble/units/constants.hpp"

namespace tumble::table {
namespace {

/// 20 Hz over 60 s; a reading stamped t is that of t + 25 ms.
Channel angles_of(const std::function<double(double)>& angle) {
  Channel channel{"table_angle", QuantityKind::angle, Unit::parse("deg"), {0.0, 20.0, nullptr}, {}};
  for (std::size_t i = 0; i < 1200; ++i) channel.values.push_back(angle(channel.time(i) + 0.025));
  return channel;
}

Kept kept_of(const Channel& channel, const Motion& motion) {
  const Encoder encoder{"table", &channel, true, 1e-6};
  return kept_motion(encoder, &motion, 5.0, 60.0);
}

/// At rest at 1 rad from `arrives` until `leaves`; before it comes, and after it goes, with 0.1 rad/s.
Channel rest_between(double arrives, double leaves) {
  return angles_of([=](double t) { return 1.0 + 0.1 * std::min(t - arrives, 0.0) + 0.1 * std::max(t - leaves, 0.0); });
}

TEST(KeptMotion, AllOfASegmentThatIsAsPlanned) {
  const Kept kept = kept_of(rest_between(4.0, 61.0), {.value = 1.0});
  EXPECT_EQ(kept.from, 5.0);
  EXPECT_EQ(kept.until, 60.0);
}

TEST(KeptMotion, ARestBeginsWhenTheAxisHasArrivedAndEndsWhenItLeaves) {
  const Kept kept = kept_of(rest_between(9.0, 54.0), {.value = 1.0});
  EXPECT_NEAR(kept.from, 9.05, 0.051);
  EXPECT_GE(kept.from, 9.0);
  EXPECT_NEAR(kept.until, 53.95, 0.051);
  EXPECT_LE(kept.until, 54.0);
}

TEST(KeptMotion, ARateBeginsWhenTheAxisHasComeToIt) {
  const double rate = 1.2;
  const Channel channel = angles_of([=](double t) { return t < 8.0 ? 0.5 * rate * t * t / 8.0 : rate * (t - 4.0); });
  const Kept kept = kept_of(channel, {.kind = Motion::Kind::rate, .value = rate});
  EXPECT_NEAR(kept.from, 8.0, 0.11);
  EXPECT_EQ(kept.until, 60.0);
}

TEST(KeptMotion, AnotherRateOrFrequencyIsKeptToo) {
  const Channel turning = angles_of([](double t) { return 1.2 * 1.001 * t; });
  EXPECT_EQ(kept_of(turning, {.kind = Motion::Kind::rate, .value = 1.2}).from, 5.0);
  const Channel oscillating = angles_of([](double t) { return 0.3 * std::sin(two_pi * 0.5005 * t); });
  const Kept kept = kept_of(oscillating, {.kind = Motion::Kind::sine, .amplitude = 0.31, .frequency = 0.5});
  EXPECT_EQ(kept.from, 5.0);
  EXPECT_EQ(kept.until, 60.0);
}

TEST(KeptMotion, AnOscillationEndsWhenTheNextMoveBegins) {
  const Channel channel =
      angles_of([](double t) { return 0.3 * std::sin(two_pi * 0.5 * t) + 0.2 * std::max(t - 52.0, 0.0); });
  const Kept kept = kept_of(channel, {.kind = Motion::Kind::sine, .amplitude = 0.3, .frequency = 0.5});
  EXPECT_EQ(kept.from, 5.0);
  EXPECT_NEAR(kept.until, 52.0, 0.11);
}

TEST(KeptMotion, OneReadingThatIsOffShortensNothing) {
  Channel channel = rest_between(4.0, 61.0);
  channel.values[150] += 0.01;
  EXPECT_EQ(kept_of(channel, {.value = 1.0}).from, 5.0);
}

}  // namespace
}  // namespace tumble::table
