#include "tumble/rigs/chain/profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::chain {
namespace {

using Kind = Motion::Kind;

constexpr double turn = 2.0 * std::numbers::pi;

Segment segment(double duration, Motion motion) { return {"s", duration, 1, {{"table", motion}}}; }
Motion hold(double angle) { return {.kind = Kind::hold, .value = angle}; }
Motion rate(double value) { return {.kind = Kind::rate, .value = value}; }
Motion slew(double speed, double to) { return {.kind = Kind::slew, .value = speed, .to = to}; }
Motion sine(double amplitude, double frequency, double phase = 0.0) {
  return {.kind = Kind::sine, .amplitude = amplitude, .frequency = frequency, .phase = phase};
}

Turn state(const Profile& profile, double time) {
  std::size_t piece = 0;
  return at(profile, time, piece);
}

/// Segments of every kind in an order that the stream chooses.
Schedule any_schedule(const RandomStream& random, std::size_t count) {
  Schedule schedule;
  for (std::size_t s = 0; s < count; ++s) {
    const double duration = 2.0 + 8.0 * random.uniform(10 * s), value = 3.0 * random.normal(10 * s + 1);
    const int kind = static_cast<int>(6.0 * random.uniform(10 * s + 2));
    Motion motion = hold(value);
    if (kind == 1) motion = rate(0.3 * value);
    if (kind == 2) motion = slew(0.2 + random.uniform(10 * s + 3), value);
    if (kind == 3) motion = sine(0.05 * value, 0.3 + random.uniform(10 * s + 4), value);
    if (kind == 4) {
      motion = sine(0.02 * value, 0.5, value);
      motion.kind = Kind::sweep;
      motion.to_frequency = 2.0;
    }
    schedule.push_back(segment(duration, motion));
    if (kind == 5) schedule.back().axes.clear();
  }
  return schedule;
}

// Angle and rate are continuous, the rate is the derivative of the angle, the acceleration that of the rate.
TEST(Profile, RateIsTheDerivativeOfTheAngleEverywhere) {
  const AxisLimits limits{"table", 2.0, 3.0};
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto schedule = any_schedule(RandomStream(seed), 12);
    const auto profile = profile_of(schedule, limits, {}, nullptr);
    for (std::size_t p = 0; p + 1 < profile.pieces.size(); ++p) {
      const double begin = profile.pieces[p].begin, end = profile.pieces[p + 1].begin;
      ASSERT_LT(begin, end + 1e-12);
      Profile one{{profile.pieces[p]}, {}};
      const Turn left = state(one, end), right = state(profile, end);
      EXPECT_NEAR(left.angle, right.angle, 1e-12 * (1.0 + std::abs(left.angle))) << "seed " << seed << " piece " << p;
      // A sine is cut off where its segment ends: what it then moves at is taken over by the next move.
      EXPECT_NEAR(left.rate, right.rate, 1e-11) << "seed " << seed << " piece " << p;
      const double middle = 0.5 * (begin + end), h = std::min(1e-4, 0.4 * (end - begin));
      if (h < 1e-6) continue;
      const Turn a = state(profile, middle - h), b = state(profile, middle), c = state(profile, middle + h);
      // h^2/6 of the third and fourth derivatives of A sin(w t), A = 0.5 rad, w = 8.2 rad/s, and rounding over h
      EXPECT_NEAR((c.angle - a.angle) / (2 * h), b.rate, 60.0 * h * h + 1e-14 * (1 + std::abs(b.angle)) / h);
      EXPECT_NEAR((c.rate - a.rate) / (2 * h), b.acceleration, 500.0 * h * h + 1e-14 / h);
    }
  }
}

TEST(Profile, MoveIsTheFastestWithinTheLimits) {
  const AxisLimits limits{"table", 2.0, 4.0};
  // long move: 0.5 s up, 0.5 s down (1 rad), the other 5 rad at 2 rad/s
  auto profile = profile_of({segment(1.0, hold(1.0)), segment(10.0, hold(7.0))}, limits, {}, nullptr);
  EXPECT_EQ(profile.settled[0], 0.0);
  EXPECT_NEAR(profile.settled[1], 1.0 + 0.5 + 2.5 + 0.5, 1e-12);
  EXPECT_NEAR(state(profile, 3.0).rate, 2.0, 1e-12);
  EXPECT_EQ(state(profile, 4.51).angle, 7.0);
  EXPECT_EQ(state(profile, 1000.0).angle, 7.0);
  // short move: sqrt(way/acceleration) up and down
  profile = profile_of({segment(1.0, hold(1.0)), segment(10.0, hold(0.5))}, limits, {}, nullptr);
  EXPECT_NEAR(profile.settled[1], 1.0 + 2.0 * std::sqrt(0.5 / 4.0), 1e-12);
  EXPECT_NEAR(state(profile, 1.0 + std::sqrt(0.5 / 4.0)).rate, -std::sqrt(0.5 * 4.0), 1e-9);
}

TEST(Profile, RateIsReachedWithTheAccelerationAndKept) {
  const AxisLimits limits{"table", 5.0, 2.0};
  const auto profile = profile_of({segment(10.0, rate(4.0)), segment(10.0, rate(-4.0))}, limits, {}, nullptr);
  EXPECT_NEAR(profile.settled[0], 2.0, 1e-12);
  EXPECT_NEAR(profile.settled[1], 14.0, 1e-12);
  EXPECT_NEAR(state(profile, 10.0).angle, 4.0 + 32.0, 1e-11);
  EXPECT_EQ(state(profile, 15.0).rate, -4.0);
  EXPECT_NEAR(state(profile, 20.0).angle, 36.0 - 24.0, 1e-11);
}

TEST(Profile, AfterARateTheNearestOfTheEqualAnglesIsHeld) {
  const AxisLimits endless{"table", 5.0, 2.0};
  auto profile = profile_of({segment(100.0, rate(4.0)), segment(10.0, hold(0.0))}, endless, {}, nullptr);
  const double angle = state(profile, 110.0).angle;
  EXPECT_NEAR(std::remainder(angle, turn), 0.0, 1e-9);
  EXPECT_NEAR(angle, 4.0 * 99.0 + 4.0, 4.0);  // at most half a turn from where it came to rest
  // with stops it goes back, and holds are literal as long as nothing turned
  const AxisLimits limited{"table", 5.0, 2.0, -7.0, 7.0};
  profile =
      profile_of({segment(3.0, rate(1.0)), segment(10.0, hold(turn)), segment(10.0, hold(0.0))}, limited, {}, nullptr);
  EXPECT_EQ(state(profile, 13.0).angle, turn);
  EXPECT_EQ(state(profile, 23.0).angle, 0.0);
}

TEST(Profile, AxisThatIsNotMentionedHoldsOrComesToRest) {
  const AxisLimits limits{"table", 5.0, 2.0};
  Segment silent{"silent", 10.0, 1, {}};
  auto profile = profile_of({segment(1.0, hold(2.0)), silent}, limits, {}, nullptr);
  EXPECT_EQ(steady_until(profile, 0.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(profile.settled[1], 1.0);
  profile = profile_of({segment(10.0, rate(4.0)), silent}, limits, {}, nullptr);
  EXPECT_NEAR(profile.settled[1], 12.0, 1e-12);
  EXPECT_NEAR(state(profile, 20.0).angle, 36.0 + 4.0, 1e-11);
  EXPECT_EQ(steady_until(profile, 5.0), 5.0);
  // a slew that its segment was too short for goes on
  profile = profile_of({segment(1.0, slew(1.0, 3.0)), silent}, limits, {}, nullptr);
  EXPECT_NEAR(profile.settled[0], 1.0, 1e-12);
  EXPECT_NEAR(profile.settled[1], 0.5 + 2.5 + 0.5, 1e-12);
  EXPECT_EQ(state(profile, 5.0).angle, 3.0);
}

TEST(Profile, SineHasThePhaseOfItsSegmentAndReturnsToWhereItStood) {
  const AxisLimits limits{"table", 5.0, 50.0};
  const auto profile = profile_of({segment(1.0, hold(0.3)), segment(9.0, sine(0.2, 0.5, 0.7)),
                                   segment(5.0, sine(0.1, 2.0)), segment(5.0, hold(0.3))},
                                  limits, {}, nullptr);
  EXPECT_NEAR(profile.settled[1], 1.0 + 2.0 / 0.5, 1e-12);
  EXPECT_NEAR(state(profile, 7.3).angle, 0.3 + 0.2 * std::sin(turn * 0.5 * 6.3 + 0.7), 1e-12);
  EXPECT_NEAR(state(profile, 14.1).angle, 0.3 + 0.1 * std::sin(turn * 2.0 * 4.1), 1e-12);
  EXPECT_EQ(state(profile, 20.0).angle, 0.3);
}

TEST(Profile, ARateWithFromIsUnderWayAndIsFollowedAsAnyRate) {
  const AxisLimits endless{"table", 5.0, 2.0};
  Motion under_way = rate(4.0);
  under_way.from = 0.8;
  const auto profile =
      profile_of({segment(5.0, hold(0.3)), segment(20.0, under_way), segment(10.0, hold(0.0))}, endless, {}, nullptr);
  EXPECT_EQ(state(profile, 4.9).angle, 0.3);
  for (const double since : {0.0, 0.1, 7.0, 19.9}) {
    EXPECT_NEAR(state(profile, 5.0 + since).angle, 0.8 + 4.0 * since, 1e-12);
    EXPECT_EQ(state(profile, 5.0 + since).rate, 4.0);
  }
  EXPECT_EQ(profile.settled[1], 5.0 + 4.0 / 2.0) << "as without `from`";
  EXPECT_NEAR(std::remainder(state(profile, 35.0).angle, turn), 0.0, 1e-9);
  EXPECT_NEAR(state(profile, 35.0).angle, 0.8 + 80.0 + 4.0, 4.0);  // brakes for 2 s, then at most half a turn
}

TEST(Profile, AnErrorOfARateTurnsAboutTheMiddleOfTheReadingsThatItsAngleFollowsFrom) {
  const AxisLimits endless{"table", 5.0, 2.0};
  Motion under_way = rate(4.0);
  under_way.from = 0.8;
  under_way.lasts = 2.0 * 11.0;
  const auto profile = profile_of({segment(20.0, under_way)}, endless, {.rate = 1e-3}, nullptr);
  for (const double time : {0.0, 11.0, 19.0})
    EXPECT_NEAR(state(profile, time).angle, 0.8 + 4.0 * time + 4e-3 * (time - 11.0), 1e-12);
}

TEST(Profile, ASineWithFromOscillatesAboutItFromTheBeginning) {
  const AxisLimits limits{"table", 5.0, 50.0};
  Motion under_way = sine(0.2, 0.5, 0.7);
  under_way.from = -0.4;
  const auto profile = profile_of(
      {segment(1.0, hold(0.3)), segment(9.0, under_way), segment(5.0, sine(0.1, 2.0)), segment(5.0, hold(0.3))}, limits,
      {}, nullptr);
  for (const double since : {0.0, 0.1, 6.3})
    EXPECT_NEAR(state(profile, 1.0 + since).angle, -0.4 + 0.2 * std::sin(turn * 0.5 * since + 0.7), 1e-12);
  EXPECT_NEAR(profile.settled[1], 1.0 + 2.0 / 0.5, 1e-12) << "as without `from`";
  EXPECT_NEAR(state(profile, 14.1).angle, -0.4 + 0.1 * std::sin(turn * 2.0 * 4.1), 1e-12) << "about where it stood";
  EXPECT_EQ(state(profile, 20.0).angle, 0.3);
}

TEST(Profile, SweepPassesItsFrequenciesLogarithmically) {
  const AxisLimits limits{"table", 50.0, 5000.0};
  Motion sweep = sine(0.01, 1.0);
  sweep.kind = Kind::sweep;
  sweep.to_frequency = 16.0;
  const auto profile = profile_of({segment(40.0, sweep)}, limits, {}, nullptr);
  // 1 Hz at the start, 2 Hz after a quarter: the cycles to time t are 40/ln 16 (16^(t/40) - 1)
  for (const double time : {10.0, 20.0, 33.3, 39.9}) {
    const double cycles = 40.0 / std::log(16.0) * (std::pow(16.0, time / 40.0) - 1.0);
    EXPECT_NEAR(state(profile, time).angle, 0.01 * std::sin(turn * cycles), 1e-12) << time;
  }
}

TEST(Profile, ErrorsActWhereTheyShould) {
  const AxisLimits limits{"table", 5.0, 2.0};
  DriveErrors errors{{1e-5, 2e-5, 4e-5, 8e-5}, 1e-3, 1e-2};
  const auto profile = profile_of({segment(5.0, hold(1.0)), segment(5.0, hold(2.0)), segment(5.0, hold(2.0)),
                                   segment(10.0, rate(2.0)), segment(10.0, sine(0.1, 1.0))},
                                  limits, errors, nullptr);
  EXPECT_DOUBLE_EQ(state(profile, 4.0).angle, 1.0 + 1e-5);
  EXPECT_DOUBLE_EQ(state(profile, 9.9).angle, 2.0 + 2e-5);
  EXPECT_DOUBLE_EQ(state(profile, 14.9).angle, 2.0 + 2e-5);  // it was not moved: nothing is drawn anew
  EXPECT_DOUBLE_EQ(state(profile, 20.0).rate, 2.0 * (1 + 1e-3));
  double largest = 0.0;
  const double rest = 0.5 * (state(profile, 34.25).angle + state(profile, 34.75).angle);
  for (double t = 33.0; t < 35.0; t += 1e-3) largest = std::max(largest, std::abs(state(profile, t).angle - rest));
  EXPECT_NEAR(largest, 0.1 * (1 + 1e-2), 1e-6);
}

TEST(Profile, AllProblemsAreListedWithTheirSegments) {
  Problems problems;
  const AxisLimits limits{"table", 1.0, 1.0, -2.0, 2.0};
  profile_of({segment(1.0, rate(1.5)), segment(50.0, hold(3.0)), segment(0.5, hold(0.0)), segment(20.0, sine(1.0, 1.0)),
              segment(20.0, hold(0.0)), segment(50.0, slew(9.0, 1.0))},
             limits, {}, &problems);
  for (const char* part : {"above its max_rate", "beyond its stop", "to reach the commanded motion",
                           "would oscillate at", "above its max_acceleration"})
    EXPECT_TRUE(has_problem(problems, {.values = {"table"}, .pattern = part})) << part;
  problems.clear();
  profile_of({segment(10.0, rate(1.0)), segment(10.0, hold(0.0))}, {"table", 1.0, 1.0}, {}, &problems);
  EXPECT_TRUE(problems.empty()) << problems.front().text();
}

}  // namespace
}  // namespace tumble::chain
