#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tumble/methods/method.hpp"
#include "tumble/methods/rlg_lock_in/dead_band.hpp"
#include "tumble/methods/rlg_lock_in/departures.hpp"
#include "tumble/methods/rlg_lock_in/random_walk.hpp"
#include "tumble/methods/rlg_lock_in/testing/trial.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/models/lock_in.hpp"
#include "tumble/models/lock_zones.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/testing/asserts.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::methods::rlg_lock_in_test {
namespace {

using namespace rlg_lock_in;

constexpr double K = 91237.4003;  // [fringe/rad]

const Method& method() { return find_method("rlg_lock_in"); }

/// Points of an exact gyro: beats by (4.23) with rate noise of density N added to the true rate.
Sweep exact_sweep(double lock_in, double bias, double walk, std::uint64_t seed) {
  Sweep sweep;
  const RandomStream random(seed);
  for (const double ratio : {0.5, 0.97, 1.08, 1.2, 1.5, 2.0, 4.0, 10.0})
    for (const double sign : {1.0, -1.0}) {
      Point point{
          .label = "rate", .moving = true, .rate = sign * ratio * lock_in, .duration = 50.0, .sample_step = 0.1};
      const double true_rate =
          point.rate + bias + walk / std::sqrt(point.duration) * random.normal(sweep.points.size());
      point.beat = K * mean_output_rate({K, lock_in}, {}, true_rate);
      sweep.points.push_back(point);
    }
  return sweep;
}

TEST(DeadBand, GivesBackAnExactSweep) {
  const double lock_in = si(0.1, "deg/s"), bias = si(5.0, "deg/h");
  const auto band = fit_dead_band(exact_sweep(lock_in, bias, 0.0, 1), {});
  EXPECT_NEAR(band.lock_in_rate, lock_in, 1e-10 * lock_in);
  EXPECT_NEAR(band.scale_factor, K, 1e-10 * K);
  EXPECT_NEAR(band.bias, bias, 1e-8 * bias);
  EXPECT_EQ(band.rows.size(), 12u);  // 0.5 in the dead band, 0.97 at its edge
  EXPECT_NEAR(beat_frequency(band, 2.0 * lock_in - bias), K * lock_in * std::sqrt(3.0), 1e-5);
  EXPECT_EQ(beat_frequency(band, 0.5 * lock_in), 0.0);
}

// A large rate noise, 1 % of W_L in a point: the mean of 400 fits departs from the truth by less than 4 standard
// errors, although a rate at 1.08 W_L comes within 8 of its standard deviations of the edge.
TEST(DeadBand, IsNotBiasedByTheNoiseOfTheRate) {
  const double lock_in = si(0.1, "deg/s"), walk = 0.01 * lock_in * std::sqrt(50.0);
  double sum = 0.0, squares = 0.0, stated = 0.0;
  const int runs = 400;
  for (int r = 0; r < runs; ++r) {
    const auto band = fit_dead_band(exact_sweep(lock_in, 0.0, walk, 100 + static_cast<std::uint64_t>(r)), {});
    const double error = band.lock_in_rate - lock_in;
    sum += error;
    squares += error * error;
    stated += band.fit.covariance(2, 2);
  }
  const double sd = std::sqrt(squares / runs);
  EXPECT_LT(std::abs(sum / runs), 4.0 * sd / std::sqrt(runs));
  EXPECT_NEAR(std::sqrt(stated / runs) / sd, 1.0, 4.0 / std::sqrt(2.0 * runs) + 0.02);  // and 0.02 of s^2's own spread
}

/// Mean beat [fringe/s] of a gyro at a constant rate [rad/s] with white noise of density N [rad/sqrt(s)], drawn anew
/// ten times a fringe and more.
double noisy_beat(const LockIn& lock, double rate, double walk, double duration, const RandomStream& random) {
  constexpr double step = 5e-4;
  std::vector<double> rates(static_cast<std::size_t>(duration / step)), fringes(rates.size());
  random.split("noise").normal(0, rates);
  for (double& r : rates) r = rate + walk / std::sqrt(step) * r;
  BeatPhase beat(lock, {}, random.split("start").uniform(0), random.split("dither"));
  const double first = beat.fringes();
  beat.advance(step, rates, fringes);
  return (fringes.back() - first) / duration;
}

// (4.33): the scatter of 3 x 200 rates solved from beats, with a sd of 4 sqrt(2/600) = 0.23 at 4 sigma. Without the
// factor the ratio would be 1.29. The ends of the record add less than 0.1 fringe^2 to the 2 of the noise: 5 %.
TEST(DeadBand, NoiseNearTheEdgeIsLargerThanTheNoiseOfTheRate) {
  const LockIn lock{K, si(0.1, "deg/s")};
  const double walk = 2e-3 * lock.rate, duration = 20.0;
  constexpr int draws = 200;
  double pooled = 0.0;
  for (const int percent : {120, 130, 150}) {
    const double ratio = 0.01 * percent, rate = ratio * lock.rate;
    const double expected = walk * walk / duration * (1.0 + 0.5 / (ratio * ratio));
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < draws; ++k) {
      const RandomStream random = RandomStream(7000 + static_cast<std::uint64_t>(k)).split(std::to_string(percent));
      const double f = noisy_beat(lock, rate, walk, duration, random);
      const double off = std::hypot(f / K, lock.rate) - rate;
      sum += off;
      squares += off * off;
    }
    pooled += (squares - sum * sum / draws) / (draws - 1.0) / expected / 3.0;
  }
  EXPECT_NEAR(pooled, 1.0, 4.0 * std::sqrt(2.0 / (3.0 * draws)) + 0.05);
}

TEST(DeadBand, RefusesWhatShowsNone) {
  const double lock_in = si(0.1, "deg/s");
  Sweep one_sided = exact_sweep(lock_in, 0.0, 0.0, 1), linear = one_sided;
  std::erase_if(one_sided.points, [](const Point& point) { return point.rate < 0.0; });
  for (std::size_t i = 0; i < linear.points.size(); ++i)
    linear.points[i].beat = K * linear.points[i].rate * (1.0 + 1e-6 * static_cast<double>(i % 4));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "two or more of each sign"},
                      [&] { fit_dead_band(one_sided, {}); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.pattern = "show no dead band"}, [&] { fit_dead_band(linear, {}); }));
}

// With dither in all segments: scale factor from rates, N from the record at rest, W_L from both. The record is drawn
// with white noise of (4.27), which the model itself is tested to give.
TEST(RlgLockIn, WithDitherInAllSegments) {
  const LockIn lock{K, si(0.1, "deg/s")};
  const Dither dither{si(100.0, "deg/s"), 400.0, 0.0};
  Plan plan = trial(1).evidence.plan;
  plan.truth.set_number("lock_in_rate", 0.0, Unit::parse("deg/s"));
  plan.truth.set_number("angle_random_walk", angle_random_walk_from_lock_in(lock, dither), Unit::parse("deg/sqrt(h)"));
  plan.settings.set_word("dither", "on");
  plan.settings.set_number("dither_rate", dither.rate, Unit::parse("deg/s"));
  plan.schedule.push_back({"at rest", 1200.0, 1, plan.schedule.front().axes});
  plan.schedule.back().axes.erase("table");
  const Estimate estimate = method().identify({plan, {simulate(plan, 4, {})}}, {});
  const auto check = [&](const char* name, double truth) {
    const Parameter* found = find_parameter(estimate, name);
    ASSERT_NE(found, nullptr) << name;
    const double sd = standard_uncertainty(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
    EXPECT_LT(std::abs(found->value - truth), 4.0 * sd) << name;
    EXPECT_LT(sd, 0.2 * std::abs(truth)) << name;
  };
  check("scale_factor", K);
  check("bias", si(3.0, "deg/h"));
  check("angle_random_walk_from_lock_in", angle_random_walk_from_lock_in(lock, dither));
  check("lock_in_rate", lock.rate);
}

TEST(RlgLockIn, SaysHowTheRandomWalkCompares) {
  const Estimate estimate = method().identify(trial(3).evidence, {});
  const auto compared = [](const Finding& finding) {
    return finding.code == "random_walk_agrees_with_lock_in" || finding.code == "random_walk_differs_from_lock_in";
  };
  EXPECT_EQ(std::ranges::count_if(estimate.findings, compared), 1);
  const Table* sweep = find_table(estimate, "sweep");
  ASSERT_NE(sweep, nullptr);
  EXPECT_EQ(sweep->rows.size(), 25u);
}

// What is predicted is what the trial then states: both sd of W_L and K are those of the same fit, with s^2 known or
// estimated from 17 degrees of freedom (4 sigma: 4/sqrt(34) of a standard deviation).
TEST(RlgLockIn, PredictsWhatItWillState) {
  const Trial one = trial(2);
  const Estimate predicted = method().predict(one.evidence.plan), found = method().identify(one.evidence, {});
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(predicted.parameters[i].name, found.parameters[i].name);
    EXPECT_NEAR(standard_uncertainty(found, i) / standard_uncertainty(predicted, i), 1.0, 4.0 / std::sqrt(34.0));
  }
}

TEST(RlgLockIn, SaysThatTheDitherWasNotOn) {
  Sweep sweep;
  sweep.points.push_back({.label = "rest", .dithered = true, .duration = 100.0, .sample_step = 0.1});
  sweep.points.back().beats.assign(1000, 0.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"rest"}, .pattern = "the counts do not change"},
                      [&] { beat_walk(sweep); }));
}

// A scale factor below zero is an error finding of every method (tasks/plausible).
TEST(RlgLockIn, AReversedGyroHasANegativeScaleFactorAndNothingElseChanges) {
  Evidence evidence = trial(1).evidence;
  const Estimate sound = method().identify(evidence, {});
  for (auto& recording : evidence.recordings)
    for (double& count : recording.channels[0].values) count = -count;
  const Estimate reversed = method().identify(evidence, {});
  ASSERT_EQ(reversed.parameters.size(), sound.parameters.size());
  for (std::size_t k = 0; k < sound.parameters.size(); ++k) {
    const auto& [a, b] = std::pair(sound.parameters[k], reversed.parameters[k]);
    EXPECT_DOUBLE_EQ(b.value, a.name == "scale_factor" ? -a.value : a.value) << a.name;
    EXPECT_DOUBLE_EQ(standard_uncertainty(reversed, k), standard_uncertainty(sound, k)) << a.name;
  }
}

TEST(RlgLockIn, CountsInTheDeadBandAreNamed) {
  Evidence evidence = trial(1).evidence;
  auto& recording = evidence.recordings[0];
  const auto& mark = recording.marks.front();  // 0.4 W_L, in the dead band
  for (std::size_t i = 50; i < 150; ++i) recording.channels[0].values[i] += 1.0;
  const Estimate estimate = method().identify(evidence, {});
  const Finding* finding = finding_of(estimate.findings, "beat_in_dead_band");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->occurrences.count, 1u);
  EXPECT_EQ(finding->occurrences.worst.label, mark.label);
  // 4 edges a fringe; a count at each end
  EXPECT_NEAR(value_of(estimate.findings, "beat_in_dead_band", "fringes"), 100.0 / 4.0, 1.0);
}

TEST(RlgLockIn, SettingsOutsideTheirRangeAreRefused) {
  Problems problems;
  resolve(method().options(), {{"edges", "5", ""}, {"edge_margin", "0 %", ""}, {"dither_rate", "-1 deg/s", ""}}, "",
          problems);
  EXPECT_EQ(problems.size(), 3u);
  Evidence evidence = trial(1).evidence;
  evidence.plan.settings.set_integer("edges", 3);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "edges = 3"}, [&] { method().identify(evidence, {}); }));
}

TEST(DeadBand, SaysHowTheSensesAndTheBiasDiffer) {
  const double lock_in = si(0.1, "deg/s"), walk = 1e-4 * lock_in * std::sqrt(50.0);
  const auto codes_of = [&](const std::function<void(Point&, std::size_t)>& change) {
    std::vector<std::string> codes;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      Sweep sweep = exact_sweep(lock_in, 0.0, walk, seed);
      for (std::size_t i = 0; i < sweep.points.size(); ++i) change(sweep.points[i], i);
      const SweepDepartures departures = departures_of(sweep, {}, fit_dead_band(sweep, {}));
      for (const Finding& one : departures.findings) codes.push_back(one.code);
    }
    return codes;
  };
  const auto again = [&](Point& point, double rate) { point.beat = K * mean_output_rate({K, lock_in}, {}, rate); };
  EXPECT_TRUE(codes_of([](Point&, std::size_t) {}).empty());
  EXPECT_EQ(codes_of([&](Point& point, std::size_t) { point.beat *= point.beat > 0.0 ? 1.01 : 1.0; }),
            std::vector<std::string>(10, "scale_factors_of_senses_differ"));
  EXPECT_EQ(codes_of([&](Point& point, std::size_t i) { again(point, point.rate + (i < 12 ? 0.0 : 0.003 * lock_in)); }),
            std::vector<std::string>(10, "bias_steps_in_sweep"));
}

/// The first trial with a bias that steps by so many counts a sample in the middle of the sweep.
Estimate with_step(double size, std::uint64_t seed) {
  Evidence evidence = trial(seed).evidence;
  auto& values = evidence.recordings[0].channels[0].values;
  double rest = 0.0;
  for (std::size_t i = values.size() / 2; i < values.size(); ++i) {
    const double all = values[i] + size + rest;
    values[i] = std::round(all);
    rest = all - values[i];
  }
  return method().identify(evidence, {});
}

// A step moves the bias, and the scatter that it makes is no noise: rates beside the dead band stay in use, and the step is
// found. A small one is in the budget.
TEST(RlgLockIn, AStepOfTheBiasIsFoundHoweverLargeAndCountedWhereItIsSmall) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Estimate large = with_step(1.0, seed);
    EXPECT_TRUE(has_finding(large.findings, "bias_steps_in_sweep")) << seed;
    const Estimate small = with_step(0.03, seed), none = method().identify(trial(seed).evidence, {});
    const Parameter* bias = find_parameter(small, "bias");
    const auto at = static_cast<std::size_t>(bias - small.parameters.data());
    EXPECT_LT(std::abs(bias->value - si(3.0, "deg/h")), 2.5 * standard_uncertainty(small, at)) << seed;
    EXPECT_GT(standard_uncertainty(small, at), 2.0 * standard_uncertainty(none, at)) << seed;
  }
}

// The parts of a segment show the noise that was simulated, whatever differs between segments.
TEST(DeadBand, TheNoiseWithinSegmentsIsThatOfTheGyro) {
  Evidence evidence = trial(1).evidence;
  evidence.recordings.resize(1), evidence.plans.resize(1);
  const double random_walk = si(0.003, "deg/sqrt(h)");
  double sum = 0.0;
  const int seeds = 10;
  for (int seed = 1; seed <= seeds; ++seed) {
    evidence.recordings[0] = trial(static_cast<std::uint64_t>(seed)).evidence.recordings[0];
    const Sweep sweep = sweep_of(evidence);
    const DeadBandOptions options{.edges = 4};
    const NoiseWithin within = noise_within(sweep, options, fit_dead_band(sweep, options));
    EXPECT_GT(within.freedom, 10.0);
    sum += within.variance / (random_walk * random_walk) / seeds;
  }
  EXPECT_NEAR(sum, 1.0, 0.4);  // 14 segments of 7 each, of which a half is counting: 14 % each; and the beat itself
}

// The dither that sampling leaves in the counts is a line, and not the random walk nor its absence.
TEST(BeatWalk, SubtractsTheDitherThatIsLeft) {
  Sweep sweep;
  Point point{.label = "dithered", .dithered = true, .duration = 400.0, .sample_step = 0.01};
  const double walk = 3.0;  // [fringe/sqrt(s)]
  point.beats.assign(40000, 0.0);
  RandomStream(3).normal(0, point.beats);
  for (std::size_t i = 0; i < point.beats.size(); ++i)
    point.beats[i] = walk * 10.0 * point.beats[i] + 400.0 * std::sin(0.17 * static_cast<double>(i));
  sweep.points.push_back(point);
  const BeatWalk found = beat_walk(sweep);
  ASSERT_EQ(found.lines.size(), 1u);
  EXPECT_NEAR(found.lines[0].frequency, 0.17 * 100.0 / (2.0 * std::numbers::pi), 1e-3);
  EXPECT_NEAR(found.lines[0].amplitude, 400.0, 5.0);
  EXPECT_NEAR(std::sqrt(found.squared) / walk, 1.0, 0.03);
}

/// Counts of one that the output does not pass, in one of the recordings or in all.
Estimate without_ones(std::uint64_t seed, std::size_t first) {
  Evidence evidence = trial(seed).evidence;
  for (std::size_t r = first; r < evidence.recordings.size(); ++r)
    for (Channel& channel : evidence.recordings[r].channels)
      if (channel.name == "gyro")
        for (double& count : channel.values) count = std::abs(count) <= 1.0 ? 0.0 : count;
  return method().identify(evidence, {});
}

TEST(RlgLockIn, SmallCountsThatAreLostWithTheDitherAreSaid) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_FALSE(has_finding(method().identify(trial(seed).evidence, {}).findings, "small_counts_lost")) << seed;
    EXPECT_GT(value(without_ones(seed, 0), "angle_random_walk_from_lock_in"),
              1.4 * value(method().identify(trial(seed).evidence, {}), "angle_random_walk_from_lock_in"));
  }
  EXPECT_TRUE(has_finding(without_ones(1, 0).findings, "small_counts_lost"));
  EXPECT_TRUE(has_finding(without_ones(2, 1).findings, "small_counts_lost"));
}

}  // namespace
}  // namespace tumble::methods::rlg_lock_in_test
