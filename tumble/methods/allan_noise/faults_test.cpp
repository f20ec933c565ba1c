#include "tumble/methods/allan_noise/faults.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"
#include "tumble/methods/testing/noise_record.hpp"
#include "tumble/reduce/uneven_bias.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double fault_rate = 100.0;

/// White noise, sd of a sample 1, and a walk.
std::vector<double> noise_and_walk(std::size_t samples, double walk, std::uint64_t seed) {
  std::vector<double> values(samples, 0.0);
  add_noise({.angle_random_walk = 0.1, .rate_random_walk = walk}, fault_rate, RandomStream(seed), values);
  return values;
}

std::vector<std::string> codes_of(const std::vector<double>& values) {
  std::vector<std::string> codes;
  for (const Finding& finding : uneven_bias(NoiseBands(values), 0.0, fault_rate, "deg/h", "gyro.x"))
    codes.push_back(finding.code);
  return codes;
}

TEST(CoarseOutput, IsSaidFromThreeStandardDeviationsOn) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto fine = noise_and_walk(20000, 0.0, seed);
    EXPECT_TRUE(coarse_output(fine, "x").empty()) << seed;
    for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 6.0}) {
      // Anywhere between two steps, apart from where a step is so far from the mean that it is hardly ever reached.
      const double offset = step * (0.15 + 0.7 * static_cast<double>(seed) / 20.0);
      auto values = fine;
      for (double& value : values) value = step * std::round((value + offset) / step);
      EXPECT_EQ(coarse_output(values, "x").size(), step < 2.5 ? 0u : 1u) << step << " " << seed;
    }
  }
}

// Steps of one standard deviation add a twelfth to the variance of the samples: 4 % of the random walk, 8 sd of it.
TEST(RoundedRecord, ItsRandomWalkIsThatBeforeTheRounding) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto fine = noise_and_walk(40000, 0.001, seed);
    auto coarse = fine;
    for (double& value : coarse) value = std::round(value);
    const Estimate before = identify_noise(noise_evidence(fine, fault_rate)),
                   after = identify_noise(noise_evidence(coarse, fault_rate));
    const double walk = value(before, "gyro.x.angle_random_walk");
    EXPECT_NEAR(value(after, "gyro.x.angle_random_walk"), walk, 0.01 * walk) << seed;
    EXPECT_TRUE(has_finding(after.findings, "rounding_taken_out")) << seed;
    EXPECT_FALSE(has_finding(before.findings, "rounding_taken_out")) << seed;
  }
}

// A counter passes the rest on to the next sample: its rounding is quantization, and no part of the random walk.
TEST(RoundedRecord, WhatACounterPassesOnStaysInTheRandomWalk) {
  auto counted = noise_and_walk(40000, 0.001, 1);
  double rest = 0.0;
  for (double& value : counted) {
    const double whole = std::round(value + rest);
    rest += value - whole;
    value = whole;
  }
  const Estimate estimate = identify_noise(noise_evidence(counted, fault_rate));
  EXPECT_FALSE(has_finding(estimate.findings, "rounding_taken_out"));
  EXPECT_NEAR(value(estimate, "gyro.x.angle_random_walk"), 0.1, 0.002);
}

TEST(FilterNearSlowTerms, IsSaidWhereTheWhiteNoiseIsShort) {
  const auto said = [](double walk, double lag) {
    ChannelNoise channel;
    channel.rate = fault_rate;
    channel.fit.terms = {{{NoiseTerm::white}}, {{NoiseTerm::random_walk}}};
    channel.fit.terms[0].kept = channel.fit.terms[1].kept = true;
    channel.fit.terms[0].squared = 1.0;
    channel.fit.terms[1].squared = walk * walk;
    channel.fit.filter = {FilterShape::first_order, 1.0 / (6.2832 * lag), 0.0};
    return filter_near_slow_terms(channel);
  };
  // the walk is as great as white noise of one at `walk` rad a sample, the filter begins at 1/lag
  EXPECT_TRUE(said(0.01, 5.0).empty());
  ASSERT_EQ(said(0.01, 10.0).size(), 1u);
  EXPECT_NEAR(std::get<double>(said(0.01, 10.0)[0].values[1].value), std::log2(10.0), 0.01);
}

TEST(UnevenBias, NothingIsSaidOfConstantNoise) {
  const NoiseModel models[] = {{.angle_random_walk = 0.1},
                               {.rate_random_walk = 1.0},
                               {.bias_instability = 1.0},
                               {.angle_random_walk = 0.1, .bias_instability = 0.1, .rate_random_walk = 0.01},
                               {.angle_random_walk = 0.1, .markov_sd = 0.5, .markov_time = 20.0}};
  for (const NoiseModel& model : models)
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      std::vector<double> values(20000, 1.0);
      add_noise(model, fault_rate, RandomStream(seed), values);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] += 0.01 * static_cast<double>(i) / fault_rate;
      EXPECT_TRUE(codes_of(values).empty()) << seed;
    }
}

TEST(UnevenBias, AStepIsAJump) {
  for (const double step : {10.0, 3.0, 1.0})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      auto values = noise_and_walk(60000, 0.005, seed);
      for (std::size_t i = 15000 + 3000 * seed; i < values.size(); ++i) values[i] += step;
      EXPECT_EQ(codes_of(values), std::vector<std::string>{"bias_jumps"}) << step << " " << seed;
    }
}

TEST(UnevenBias, PopcornNoiseIsJumps) {
  for (const double level : {5.0, 1.0})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      auto values = noise_and_walk(60000, 0.005, seed);
      const auto stream = RandomStream(seed).split("popcorn");
      bool up = false;
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (stream.uniform(i) < 1.0 / (20.0 * fault_rate)) up = !up;
        if (up) values[i] += level;
      }
      EXPECT_EQ(codes_of(values), std::vector<std::string>{"bias_jumps"}) << level << " " << seed;
    }
}

TEST(UnevenBias, ATransientAfterPowerUpIsSaidAsOne) {
  struct Transient {
    double size, time;  // [sd of a sample], [s]
  };
  for (const Transient& one : {Transient{20.0, 30.0}, {3.0, 30.0}, {10.0, 150.0}, {3.0, 150.0}})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      auto values = noise_and_walk(60000, 0.005, seed);
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] += one.size * std::exp(-static_cast<double>(i) / fault_rate / one.time);
      EXPECT_EQ(codes_of(values), std::vector<std::string>{"bias_settles"})
          << one.size << " " << one.time << " " << seed;
    }
}

TEST(UnevenBias, AStepIsNoKnock) {
  auto values = noise_and_walk(60000, 0.005, 1);
  for (std::size_t i = 30007; i < values.size(); ++i) values[i] += 10.0;
  const Estimate estimate = identify_noise(noise_evidence(std::move(values), fault_rate));
  EXPECT_NE(finding_of(estimate.findings, "bias_jumps"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "knocks"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "knocks_set_aside"), nullptr);
  EXPECT_EQ(finding_of(estimate.findings, "outliers_change_terms"), nullptr);
}

}  // namespace
}  // namespace tumble::allan_noise
