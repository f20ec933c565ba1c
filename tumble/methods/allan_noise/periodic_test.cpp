#include "tumble/methods/allan_noise/periodic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/regression/least_squares.hpp"
#include "tumble/methods/testing/noise_record.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double turn = 2.0 * std::numbers::pi;

std::vector<double> simulated_samples(const NoiseModel& model, std::size_t samples, std::uint64_t seed) {
  std::vector<double> values(samples, 0.3);
  add_noise(model, 1.0, RandomStream(seed), values);
  return values;
}

void put(double amplitude, double frequency, double phase, std::vector<double>& values) {
  for (std::size_t n = 0; n < values.size(); ++n)
    values[n] += amplitude * std::cos(turn * frequency * static_cast<double>(n) + phase);
}

PeriodicFit fitted(const std::vector<double>& values) {
  const NoiseBands bands(values);
  return fit_beside_lines(values, bands, fit_noise(bands, {}), {});
}

/// How often intervals held, and the mean and scatter of the errors in standard uncertainties.
struct Tally {
  int count = 0, held = 0;
  double sum = 0.0;
  void add(double error, double sd, double factor) {
    ++count;
    held += std::abs(error) <= factor * sd ? 1 : 0;
    sum += error / sd;
  }
  void expect_honest(const char* of, int records) const {
    EXPECT_EQ(count, records) << of;
    EXPECT_NEAR(static_cast<double>(held) / records, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / records)) << of;
    EXPECT_LT(std::abs(sum) / records, 4.0 / std::sqrt(1.0 * records)) << of;
  }
};

TEST(FitBesideLinesCoverage, NoiseAndLinesAreHeldBesideEachOther) {
  // White noise and walk with mains of 30 sd of a sample, a harmonic that it hides, and a thermal cycle of 12.3 periods
  // in the walk. As often held as without lines, within 4 sigma.
  constexpr int records = 200;
  constexpr std::size_t samples = 12000;
  constexpr double n = 1.0, k = 0.02;
  const double frequencies[] = {0.05003, 0.15009, 12.3 / samples}, amplitudes[] = {30.0, 0.3, 5.0};
  Tally amplitude[3], frequency[3], white, walk;
  for (unsigned seed = 1; seed <= records; ++seed) {
    auto values = simulated_samples({.angle_random_walk = n, .rate_random_walk = k}, samples, seed);
    for (std::size_t i = 0; i < 3; ++i) put(amplitudes[i], frequencies[i], seed + 2.0 * static_cast<double>(i), values);
    const PeriodicFit fit = fitted(values);
    ASSERT_EQ(fit.lines.size(), 3u) << seed;
    EXPECT_TRUE(fit.wandering.empty()) << seed;
    for (const FittedLine& line : fit.lines)
      for (std::size_t i = 0; i < 3; ++i) {
        if (std::abs(line.frequency - frequencies[i]) > 2.0 / samples) continue;
        amplitude[i].add(line.amplitude - amplitudes[i], line.amplitude_sd, 1.96);
        frequency[i].add(line.frequency - frequencies[i], line.frequency_sd, 1.96);
      }
    const auto tell = [&](const FittedTerm& term, double truth, Tally& tally) {
      ASSERT_TRUE(term.kept) << seed;
      const double root = std::sqrt(term.squared), sd = 0.5 * term.squared_sd / root;
      tally.add(root * term.root_correction - truth, sd, student_quantile(0.975, term.degrees_of_freedom));
    };
    tell(fit.fit.terms[1], n, white);
    tell(fit.fit.terms[3], k, walk);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    amplitude[i].expect_honest("amplitude", records);
    frequency[i].expect_honest("frequency", records);
  }
  white.expect_honest("N", records);
  walk.expect_honest("K", records);
}

TEST(FitBesideLines, NoneInNoise) {
  // A false one takes a fit that fails at 0.1 % or a slow sine that chance gives in 1 %, and then 1 in 10^4.
  for (unsigned seed = 1; seed <= 25; ++seed)
    for (const NoiseModel& model :
         {NoiseModel{.angle_random_walk = 1.0}, NoiseModel{.angle_random_walk = 1.0, .rate_random_walk = 0.05},
          NoiseModel{.bias_instability = 1.0},
          NoiseModel{.angle_random_walk = 1.0, .markov_sd = 2.0, .markov_time = 60.0}})
      EXPECT_TRUE(fitted(simulated_samples(model, 6000, seed)).lines.empty()) << seed;
}

TEST(FitBesideLines, WhatWandersIsNotMistakenForASine) {
  // A vibration whose phase walks by a turn within some hundred samples, and one that drifts over 100 resolutions.
  for (unsigned seed = 1; seed <= 5; ++seed) {
    auto walking = simulated_samples({.angle_random_walk = 1.0}, 32768, seed), drifting = walking;
    const auto phase = simulated_samples({.rate_random_walk = 0.05}, 32768, 100 + seed);
    for (std::size_t i = 0; i < walking.size(); ++i) {
      const double t = static_cast<double>(i);
      walking[i] += std::cos(turn * 0.2 * t + phase[i]);
      drifting[i] += std::cos(turn * (0.2 + 5e-8 * t) * t);
    }
    for (const auto& values : {walking, drifting}) {
      const PeriodicFit fit = fitted(values);
      EXPECT_TRUE(fit.lines.empty()) << seed;
      ASSERT_FALSE(fit.wandering.empty()) << seed;
      EXPECT_NEAR(fit.wandering[0].frequency, 0.2, 0.005) << seed;
      EXPECT_NEAR(fit.fit.terms[1].squared, 1.0, 4.0 * fit.fit.terms[1].squared_sd) << seed;
    }
  }
}

TEST(FitBesideLines, FindsLinesSlowerThanThePeriodogramSees) {
  // 262144 samples: the periodogram sees 8/4096 and up, of means over 16 samples 8/65536; below, the sines do.
  for (const double frequency : {30.3 / 262144, 70.7 / 262144, 1.0 / 1000.3, 0.31}) {
    auto values = simulated_samples({.angle_random_walk = 1.0, .rate_random_walk = 0.003}, 262144, 5);
    const double amplitude = 0.3;
    put(amplitude, frequency, 2.0, values);
    const PeriodicFit fit = fitted(values);
    ASSERT_EQ(fit.lines.size(), 1u) << frequency;
    EXPECT_NEAR(fit.lines[0].frequency, frequency, 4.0 * fit.lines[0].frequency_sd);
    EXPECT_NEAR(fit.lines[0].amplitude, amplitude, 4.0 * fit.lines[0].amplitude_sd);
    EXPECT_LT(fit.lines[0].frequency_sd, 0.05 / 262144.0);
    EXPECT_EQ(fit.fit.model_error, 0.0);
  }
}

TEST(FitBesideLines, AllanVarianceIsThatOfASampledSine) {
  // Mean over a record of 1000 periods.
  FittedLine line;
  line.frequency = 0.0625;
  line.amplitude = 3.0;
  std::vector<double> values(16000, 0.0);
  put(3.0, 0.0625, 0.4, values);
  for (const std::size_t m : {1u, 3u, 6u, 20u}) {
    double sum = 0.0, count = 0.0;
    for (std::size_t first = 0; first + 2 * m <= values.size() && first < 15936; ++first) {
      double difference = 0.0;
      for (std::size_t i = 0; i < m; ++i)
        difference += (values[first + m + i] - values[first + i]) / static_cast<double>(m);
      sum += 0.5 * difference * difference;
      ++count;
    }
    EXPECT_NEAR(allan_variance_of(line, static_cast<double>(m)), sum / count, 1e-9) << m;
  }
}

Estimate identified_lines(std::vector<double> values, const char* lines) {
  Evidence evidence = noise_evidence(std::move(values), 100.0);
  evidence.plan.settings.set_word("lines", lines);
  return identify_noise(evidence);
}

TEST(FitBesideLines, AreListedAndCanBeAvoidedInstead) {
  auto values = simulated_samples({.angle_random_walk = 1e-5}, 30000, 6);
  put(2e-5, 0.12345, 1.0, values);
  const Estimate fit = identified_lines(values, "fit");
  const Table* table = find_table(fit, "lines");
  ASSERT_NE(table, nullptr);
  ASSERT_EQ(table->rows.size(), 1u);
  // A line of amplitude A in n samples with the scatter s has its frequency to sqrt(6/n) s/A/(pi T); 4 sigma.
  const double frequency_sd = std::sqrt(6.0 / 30000.0) * (1e-5 / 2e-5) / (0.5 * turn * 300.0);
  EXPECT_NEAR(std::stod(std::get<std::string>(table->rows[0][1])), 12.345, 4.0 * frequency_sd);
  EXPECT_EQ(std::get<std::string>(table->rows[0][7]), "steady");
  const auto curve = [&](const std::string& name) {
    for (const auto& one : fit.curves)
      if (one.name == name) return one;
    return Curve{};
  };
  const Curve measured = curve("gyro.x allan_deviation"), sum = curve("gyro.x fitted"), lines = curve("gyro.x lines");
  ASSERT_FALSE(lines.y.values.empty());
  for (std::size_t i = 0; i < 12; ++i)  // up to 0.16 s: 30 000 and more degrees of freedom of the noise
    EXPECT_NEAR(sum.y.values[i], measured.y.values[i], 0.03 * measured.y.values[i]) << i;
  EXPECT_EQ(find_table(identified_lines(values, "avoid"), "lines"), nullptr);
}

}  // namespace
}  // namespace tumble::allan_noise
