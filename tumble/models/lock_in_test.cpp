#include "tumble/models/lock_in.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "tumble/models/lock_zones.hpp"
#include "tumble/models/ring_laser_gyro/testing/beat_reference.hpp"
#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

constexpr double K = 91237.4003;  // [fringe/rad]

double deg(double value) { return si(value, "deg/s"); }

/// Fringes after `seconds` at a constant rate in `parts` steps.
double fringes_after(BeatPhase beat, double rate, double seconds, std::size_t parts) {
  const std::vector<double> rates(parts, rate);
  std::vector<double> fringes(parts);
  beat.advance(seconds / static_cast<double>(parts), rates, fringes);
  return fringes.back();
}

// (4.23): in the dead band the phase comes to rest at sin psi = W/W_L; outside of it n beats take n/(K
// sqrt(W^2-W_L^2)).
TEST(BeatPhase, RestsInTheDeadBand) {
  const LockIn lock{K, deg(0.1)};
  for (const double ratio : {-0.99, -0.3, 0.0, 0.5, 0.999}) {
    const double end = fringes_after({lock, {}, 0.21, RandomStream(1)}, ratio * lock.rate, 2.0, 7);
    EXPECT_NEAR(std::sin(2.0 * std::numbers::pi * end), ratio, 1e-9);
    EXPECT_LT(std::abs(end), 1.0);
  }
}

TEST(BeatPhase, BeatsAtTheSquareRootOutsideOfTheDeadBand) {
  const LockIn lock{K, deg(0.1)};
  for (const double ratio : {-50.0, -1.5, -1.0001, 1.00001, 1.1, 3.0, 1000.0}) {
    const double rate = ratio * lock.rate;
    const double beat = K * std::sqrt((rate - lock.rate) * (rate + lock.rate));
    const double whole = 3.0 / beat;  // three beats bring psi back whatever it was
    for (const std::size_t parts : {std::size_t{1}, std::size_t{1000}}) {
      const double end = fringes_after({lock, {}, 0.21, RandomStream(1)}, rate, whole, parts);
      EXPECT_NEAR(end, 0.21 + std::copysign(3.0, ratio), 1e-7) << ratio << " " << parts;
    }
  }
}

TEST(BeatPhase, WithoutLockInCountsTheAngle) {
  const double rate = deg(15.0);
  EXPECT_NEAR(fringes_after({{K, 0.0}, {}, 0.0, RandomStream(1)}, rate, 100.0, 30), K * rate * 100.0, 1e-6);
  const Dither dither{deg(100.0), 400.0, 0.02};
  EXPECT_NEAR(fringes_after({{K, 0.0}, dither, 0.0, RandomStream(1)}, rate, 1.0, 3), K * rate, 1e-8);
}

TEST(BeatPhase, DoesNotDependOnHowTheTimeIsDivided) {
  const LockIn lock{K, deg(0.1)};
  const BeatPhase free(lock, {}, 0.4, RandomStream(1));
  EXPECT_NEAR(fringes_after(free, 1.3 * lock.rate, 1.0, 1), fringes_after(free, 1.3 * lock.rate, 1.0, 999), 1e-9);
  const BeatPhase dithered(lock, {deg(100.0), 400.0, 0.03}, 0.4, RandomStream(1));
  // The steps differ, and each way departs from the solution by some 1e-5 turns that do not add up.
  EXPECT_NEAR(fringes_after(dithered, lock.rate, 0.1, 1), fringes_after(dithered, lock.rate, 0.1, 77), 1e-4);
}

struct Setting {
  double lock_in, dither, frequency, noise, input;  // deg/s, deg/s, Hz, 1, deg/s
};

// Against Runge-Kutta steps. The mean output rate, first two periods apart, is to hold 1e-6 W_L over a time long enough
// for phase errors that do not add up to drop below: 60 periods leave 1e-5 turns/(K T W_L) = 4e-7 of W_L at W_L =
// 0.1 deg/s. bench/lock_in.cpp measures the same over 400 periods.
TEST(BeatPhase, KeepsTheMeanRateWithinAMillionthOfTheLockInRate) {
  for (const Setting& s : {Setting{0.1, 100, 400, 0, 0.01}, Setting{0.25, 100, 400, 0.02, 0.02},
                           Setting{0.1, 3, 400, 0, 0.01}, Setting{0.1, 30, 421, 0.05, 0.4}}) {
    const LockIn lock{K, deg(s.lock_in)};
    const Dither dither{deg(s.dither), s.frequency, s.noise};
    const RandomStream random(3);
    testing::BeatReference reference(lock, dither, deg(s.input), random, 4000);
    BeatPhase beat(lock, dither, 0.0, random);
    double first = 0.0, ours = 0.0, theirs = 0.0;
    const double rate = deg(s.input), period = 1.0 / s.frequency;
    for (int i = 0; i < 62; ++i) {
      beat.advance(period, std::span(&rate, 1), std::span(&ours, 1));
      reference.half_cycle();
      theirs = reference.half_cycle();
      if (i == 1) first = ours - theirs;
    }
    EXPECT_LT(std::abs(ours - theirs - first) / (K * lock.rate * 60.0 * period), 1e-6) << s.dither << " " << s.input;
    EXPECT_GT(std::abs(theirs), 0.1);  // and lock-in was at work
  }
}

/// Mean rate [rad/s] of d psi = (a - e sin psi) dt + sqrt(2 D) dB: a + e Im p_1 of the stationary density, whose modes
/// p_k = <e^{-i k psi}> obey (i a + D k) p_k = e/2 (p_{k-1} - p_{k+1}), a continued fraction (Risken, The Fokker-Planck
/// equation, 1989, section 11.5).
double mean_turn(double a, double e, double D) {
  std::complex<double> quotient = 0.0;
  for (int k = 20000; k > 0; --k) quotient = 0.5 * e / (std::complex<double>(D * k, a) + 0.5 * e * quotient);
  return a + e * quotient.imag();
}

// White noise that is given as means over steps far longer than a beat has the mean rate of the stationary density, and
// near the edge the gain of (4.33). Held over each step it acted like other rates: at 1.1 W_L the mean was 0.25 %
// lower.
TEST(BeatPhase, WhiteNoiseActsWithinALongStep) {
  const LockIn lock{K, deg(0.1)};
  const double walk = si(0.01, "deg/sqrt(h)"), step = 0.02;
  const double radians = 2.0 * std::numbers::pi * K;
  for (const double ratio : {0.97, 1.0, 1.1, 1.5}) {
    const double seconds = 2.0;
    const std::size_t steps = 100, pieces = 100;
    BeatPhase beat(lock, {}, 0.2, RandomStream(7), walk * walk);
    std::vector<double> rates(steps), fringes(steps), turns;
    const RandomStream noise = RandomStream(8).split(static_cast<std::uint64_t>(1000.0 * ratio));
    for (std::size_t p = 0; p <= pieces; ++p) {
      noise.normal(p * steps, rates);
      for (double& rate : rates) rate = ratio * lock.rate + walk / std::sqrt(step) * rate;
      const double before = beat.fringes();
      beat.advance(step, rates, fringes);
      if (p > 0) turns.push_back((fringes.back() - before) / seconds);
    }
    double mean = 0.0, squares = 0.0;
    for (const double turn : turns) mean += turn / static_cast<double>(pieces);
    for (const double turn : turns) squares += (turn - mean) * (turn - mean);
    const double sd = std::sqrt(squares / static_cast<double>(pieces - 1));
    const double expected =
        mean_turn(radians * ratio * lock.rate, radians * lock.rate, 0.5 * std::pow(radians * walk, 2)) /
        (2.0 * std::numbers::pi);
    EXPECT_NEAR(mean, expected, 4.0 * sd / std::sqrt(static_cast<double>(pieces))) << ratio;
    if (ratio < 1.05) continue;
    const double slope = ratio / std::sqrt(ratio * ratio - 1.0);
    const double gain = K * walk * slope * std::sqrt((1.0 + 0.5 / (ratio * ratio)) / seconds);
    EXPECT_NEAR(sd / gain, 1.0, 4.0 / std::sqrt(2.0 * static_cast<double>(pieces))) << ratio;
  }
}

TEST(BeatPhase, ReadoutOnTheBlockShowsTheDither) {
  const Dither dither{deg(100.0), 400.0, 0.0};
  BeatPhase beat({K, 0.0}, dither, 0.0, RandomStream(1));
  const double swing = phase_excursion({K, 0.0}, dither) / (2.0 * std::numbers::pi);
  EXPECT_NEAR(beat.dither_fringes(), -swing, 1e-12);
  const double rate = 0.0, at[]{0.25, 0.25, 0.5, 0.125};
  const double expected[]{0.0, swing, -swing, -swing * std::sqrt(0.5)};
  double fringes = 0.0;
  for (int i = 0; i < 4; ++i) {
    beat.advance(at[i] / dither.frequency, std::span(&rate, 1), std::span(&fringes, 1));
    EXPECT_NEAR(beat.dither_fringes(), expected[i], 1e-9 * swing);
  }
}

TEST(BeatPhase, SameStreamSameFringes) {
  const auto run = [](std::uint64_t seed) {
    return fringes_after({{K, deg(0.1)}, {deg(100.0), 400.0, 0.02}, 0.0, RandomStream(seed)}, 0.0, 0.1, 10);
  };
  EXPECT_EQ(run(5), run(5));
  EXPECT_NE(run(5), run(6));
}

// The rotation number of one period against 2000 periods of the phase itself: psi departs from its mean advance by less
// than a turn.
TEST(MeanOutputRate, IsWhatTheBeatPhaseAdvancesBy) {
  const double frequency = 400.0, seconds = 5.0;
  const LockIn lock{K, 0.4 * frequency / K};
  const Dither dither{12.0 * frequency / K, frequency, 0.0};
  for (const double ratio : {-2.3, -0.4, -0.01, 0.0, 0.02, 0.2, 2.49, 2.51, 7.0}) {
    const double rate = ratio * lock.rate;
    const double end = fringes_after({lock, dither, 0.0, RandomStream(1)}, rate, seconds, 1);
    EXPECT_NEAR(end, K * seconds * mean_output_rate(lock, dither, rate), 1.0) << ratio;
  }
  EXPECT_EQ(mean_output_rate(lock, {}, 0.5 * lock.rate), 0.0);
  EXPECT_DOUBLE_EQ(mean_output_rate(lock, {}, -1.25 * lock.rate), -0.75 * lock.rate);
}

// (4.26): the half widths, centres and the output beside the zones within 1 % of W_n, with the pull of the other zones
// where |J_n| is small (x = 3, n = 5: without it the output is off by 46 %).
TEST(LockZones, HaveTheStatedWidthCentreAndOutput) {
  const double frequency = 400.0;
  const LockIn lock{K, 0.05 * frequency / K};
  struct Case {
    double x;
    int n;
  };
  for (const Case& c : {Case{10, 0}, Case{10, -1}, Case{30, 0}, Case{100, 2}, Case{3, 5}}) {
    const Dither dither{c.x * frequency / K, frequency, 0.0};
    const LockZone zone = lock_zone(lock, dither, c.n);
    double edge[2]{};
    for (int side = 0; side < 2; ++side) {
      double inside = 0.0, outside = 3.0 * zone.half_width;
      for (int i = 0; i < 20; ++i) {
        const double middle = 0.5 * (inside + outside);
        const double rate = zone.centre - zone.pull + (side == 0 ? -middle : middle);
        const bool locked = std::abs(mean_output_rate(lock, dither, rate) - zone.centre) < 1e-9 * zone.half_width;
        (locked ? inside : outside) = middle;
      }
      edge[side] = inside;
    }
    EXPECT_NEAR((edge[0] + edge[1]) / 2.0, zone.half_width, 0.01 * zone.half_width) << c.x << " " << c.n;
    EXPECT_NEAR(edge[0], edge[1], 0.02 * zone.half_width) << c.x << " " << c.n;
    for (const double off : {-3.0, -1.5, -1.1, 0.0, 0.9, 1.1, 1.5, 3.0}) {
      const double rate = zone.centre - zone.pull + off * zone.half_width;
      EXPECT_NEAR(mean_output_rate(lock, dither, rate), output_near_zone(lock, dither, c.n, rate),
                  0.01 * zone.half_width)
          << c.x << " " << c.n << " " << off;
    }
  }
}

// (4.27) at six settings, 4 standard deviations of a root mean square of n normal numbers, 4/sqrt(2 n). Pieces begin
// at the highest dither rate, so that no turn-around is cut in two.
TEST(RandomWalkFromLockIn, IsAsTheFormulaSays) {
  const int pieces = 400;
  int number = 0;
  for (const Setting& s :
       {Setting{0.1, 50, 400, 0.05, 0}, Setting{0.1, 50, 400, 0.05, 0.17}, Setting{0.03, 50, 401, 0.05, 0.01},
        Setting{0.05, 60, 382, 0.04, 0.05}, Setting{0.1, 100, 421, 0.03, 0}, Setting{0.15, 75, 400, 0.04, 0.01}}) {
    const LockIn lock{K, deg(s.lock_in)};
    const Dither dither{deg(s.dither), s.frequency, s.noise};
    const double rate = deg(s.input), step = 8.0 / s.frequency;
    BeatPhase beat(lock, dither, 0.3, RandomStream(20).split(static_cast<std::uint64_t>(number++)));
    double before = 0.0, now = 0.0, squares = 0.0;
    beat.advance(0.25 / s.frequency, std::span(&rate, 1), std::span(&before, 1));
    for (int i = 0; i < pieces; ++i, before = now) {
      beat.advance(step, std::span(&rate, 1), std::span(&now, 1));
      squares += std::pow((now - before) / K - rate * step, 2);
    }
    const double walk = std::sqrt(squares / pieces / step);
    EXPECT_NEAR(walk / angle_random_walk_from_lock_in(lock, dither), 1.0, 4.0 / std::sqrt(2.0 * pieces)) << number;
  }
}

// Of the lecture's gyro: K = 91237.4 pulse/rad, W_L = 0.1 deg/s, W_A = 100 deg/s, 400 Hz.
TEST(RandomWalkFromLockIn, WorkedNumbers) {
  const LockIn lock{K, deg(0.1)};
  const Dither dither{deg(100.0), 400.0, 0.0};
  EXPECT_NEAR(angle_random_walk_from_lock_in(lock, dither), 1.7449e-6, 5e-11);
  EXPECT_NEAR(Unit::parse("deg/sqrt(h)").from_si(angle_random_walk_from_lock_in(lock, dither)), 0.00600, 5e-6);
  EXPECT_NEAR(Unit::parse("deg/h").from_si(residual_lock_in_rate(lock, dither)), 14.396, 5e-4);
  // N = W_R/(2 sqrt(f_D))
  EXPECT_NEAR(residual_lock_in_rate(lock, dither) / (2.0 * std::sqrt(400.0)),
              angle_random_walk_from_lock_in(lock, dither), 1e-15);
}

}  // namespace
}  // namespace tumble
