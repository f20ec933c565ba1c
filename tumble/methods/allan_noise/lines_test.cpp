#include "tumble/methods/allan_noise/lines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "tumble/math/noise/noise_likelihood.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/methods/testing/answer.hpp"

namespace tumble::allan_noise {
namespace {

std::vector<double> simulated_values(const NoiseModel& model, std::size_t samples, std::uint64_t seed) {
  std::vector<double> values(samples, 0.0);
  add_noise(model, 1.0, RandomStream(seed), values);
  return values;
}

void add_sine(double amplitude, double frequency, std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] += amplitude * std::sin(2.0 * std::numbers::pi * frequency * static_cast<double>(i) + 1.0);
}

TEST(SpectralLines, FindsASineWithItsFrequencyAndAmplitude) {
  // 16 segments of 4096, white noise of sd 1. An amplitude is known to sqrt(2/n) at best, 0.0055; a Hann window without
  // overlap uses two thirds of the record: 0.007. 4 sd for each of 40, and 4 of the mean's.
  constexpr std::size_t samples = 65536;
  constexpr double amplitude = 0.3, resolution = 1.0 / 4096.0;
  double sum = 0.0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    // Anywhere between two frequencies of the transform.
    const double frequency = (400.0 + 0.025 * seed) * resolution;
    auto values = simulated_values({.angle_random_walk = 1.0}, samples, seed);
    add_sine(amplitude, frequency, values);
    const auto lines = spectral_lines(values);
    ASSERT_EQ(lines.size(), 1u) << seed;
    EXPECT_NEAR(lines[0].frequency, frequency, 0.51 * resolution) << seed;
    EXPECT_LT(std::abs(lines[0].frequency - frequency), lines[0].width);
    EXPECT_NEAR(lines[0].amplitude, amplitude, 4.0 * 0.007) << seed;
    sum += lines[0].amplitude;
  }
  EXPECT_NEAR(sum / 40.0, amplitude, 4.0 * 0.007 / std::sqrt(40.0));
}

TEST(SpectralLines, FindsASineWithSingleSamplesMissing) {
  // 2 of every 23 samples are missing: a pattern of its own frequency, beside whose multiples the sine has images.
  auto values = simulated_values({.angle_random_walk = 1.0}, 65536, 7);
  add_sine(0.6, 0.05, values);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (i * i % 23 == 3) values[i] = std::nan("");
  const auto lines = spectral_lines(values);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(lines[0].frequency, 0.05, 1.0 / 4096.0);
}

TEST(SpectralLines, FindsAWeakerSineWithSamplesMissing) {
  auto values = simulated_values({.angle_random_walk = 1.0}, 65536, 7);
  add_sine(0.6, 0.05, values);
  add_sine(0.3, 0.2, values);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (i * i % 23 == 3) values[i] = std::nan("");
  const auto lines = spectral_lines(values);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NEAR(lines[1].frequency, 0.2, 1.0 / 4096.0);
}

TEST(SpectralLines, StrongestFirstAndSeveral) {
  auto values = simulated_values({.angle_random_walk = 1.0}, 65536, 7);
  add_sine(0.3, 0.2, values);
  add_sine(0.6, 0.05, values);
  const auto lines = spectral_lines(values);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NEAR(lines[0].frequency, 0.05, 1.0 / 4096.0);
  EXPECT_NEAR(lines[1].frequency, 0.2, 1.0 / 4096.0);
}

TEST(SpectralLines, NoneInNoise) {
  // 10 sd above the median: of an average of 8 segments and more, once in 1e7 frequencies and less. 60 records of white
  // noise, of a walk and of flicker, and short ones.
  for (unsigned seed = 1; seed <= 60; ++seed) {
    EXPECT_TRUE(spectral_lines(simulated_values({.angle_random_walk = 1.0}, 32768, seed)).empty()) << seed;
    EXPECT_TRUE(
        spectral_lines(simulated_values({.angle_random_walk = 1.0, .rate_random_walk = 0.05}, 32768, seed)).empty())
        << seed;
    EXPECT_TRUE(spectral_lines(simulated_values({.bias_instability = 1.0}, 8192, seed)).empty()) << seed;
    EXPECT_TRUE(spectral_lines(simulated_values({.quantization_noise = 1.0}, 1000, seed)).empty()) << seed;
  }
  EXPECT_TRUE(spectral_lines(simulated_values({.angle_random_walk = 1.0}, 100, 1)).empty());  // too short to tell
}

TEST(SpectralLines, BandsThatALineFallsIntoAreSkipped) {
  constexpr double frequency = 0.11;
  auto values = simulated_values({.angle_random_walk = 1.0, .rate_random_walk = 0.01}, 65536, 8);
  add_sine(0.5, frequency, values);
  const NoiseBands bands(values);
  const auto lines = spectral_lines(values);
  ASSERT_EQ(lines.size(), 1u);
  const NoiseBands rest = without_lines(bands, lines);
  EXPECT_LT(rest.bands.size(), bands.bands.size());
  EXPECT_GT(rest.bands.size(), bands.bands.size() / 2);
  for (const auto& band : rest.bands) {
    EXPECT_GT(std::abs(band.frequency - frequency), lines[0].width);
  }
  // With it the record does not fit white noise and walk, without it both are as they are.
  const NoiseFit with = fit_noise(bands, {}), without = fit_noise(rest, {});
  EXPECT_GT(with.model_error, 0.0);
  EXPECT_EQ(without.model_error, 0.0);
  ASSERT_TRUE(without.terms[1].kept && without.terms[3].kept);
  EXPECT_NEAR(without.terms[1].squared, 1.0, 4.0 * without.terms[1].squared_sd);
  EXPECT_NEAR(without.terms[3].squared, 1e-4, 4.0 * without.terms[3].squared_sd);
}

TEST(SpectralLines, OneNextToHalfTheRateIsFound) {
  // Within two frequencies of the transform of half the rate no line was looked for: quantization stood for it.
  auto values = simulated_values({.angle_random_walk = 1.0}, 40000, 12);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] += 0.5 * std::cos(2.0 * std::numbers::pi * 0.4999 * static_cast<double>(i) + 0.7);
  const auto lines = spectral_lines(values);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(lines[0].frequency, 0.4999, lines[0].width);
}

TEST(ChangesAlong, NoneInSteadyNoiseAndOneWhereItGrows) {
  // 5 sd in one of 16 parts: once in 1e5 records.
  for (unsigned seed = 1; seed <= 60; ++seed)
    EXPECT_TRUE(
        changes_along(NoiseBands(simulated_values({.angle_random_walk = 1.0}, 32768, seed)), 0.0, 1.0, "x").empty());
  // Of smooth noise few of the contrasts hold the power: before, 6 of 20 gave a finding.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    auto smooth = simulated_values({.angle_random_walk = 1.0}, 32798, seed);
    for (int time = 0; time < 3; ++time)
      for (std::size_t i = 0; i + 10 < smooth.size(); ++i)
        smooth[i] = std::accumulate(smooth.begin() + i, smooth.begin() + i + 10, 0.0) / 10.0;
    smooth.resize(32768);
    EXPECT_TRUE(changes_along(NoiseBands(smooth), 0.0, 1.0, "x").empty()) << seed;
  }
  auto values = simulated_values({.angle_random_walk = 1.0}, 65536, 9);
  for (std::size_t i = 24576; i < 28672; ++i) values[i] *= 1.3;  // the seventh sixteenth
  const Findings findings = changes_along(NoiseBands(values), 100.0, 1.0, "gyro");
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].severity, Finding::Severity::warning);
  EXPECT_EQ(findings[0].where, "gyro");
  EXPECT_EQ(value_of(findings, "noise_changes_along_record", "from"), 24676.0);
  EXPECT_EQ(value_of(findings, "noise_changes_along_record", "to"), 28772.0);
}

}  // namespace
}  // namespace tumble::allan_noise
