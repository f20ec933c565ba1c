#include "tumble/math/spectrum/power_spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::power_spectrum_test {
namespace {

constexpr double rate = 10.0;

std::vector<double> white(std::uint64_t seed, std::size_t samples) {
  std::vector<double> values(samples);
  RandomStream(seed).normal(0, values);
  return values;
}

/// Over records of unit white noise, whose one-sided density is 2/rate.
struct Tally {
  double mean = 0.0, covered = 0.0, squares = 0.0, edf = 0.0, count = 0.0, samples = 0.0;
};

Tally tally(SpectrumEstimator estimator, const SpectrumOptions& options, std::size_t gap) {
  Tally tally;
  constexpr std::uint64_t records = 250;
  const std::size_t samples = estimator == SpectrumEstimator::welch ? 2048 : 512;
  for (std::uint64_t seed = 0; seed < records; ++seed) {
    auto values = white(1000 + seed, samples);
    for (std::size_t i = 700; i < 700 + gap; ++i) values[i] = std::numeric_limits<double>::quiet_NaN();
    const auto spectrum = power_spectrum(estimator, values, rate, options);
    for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
      tally.mean += spectrum.density[k] * 0.5 * rate;
      tally.squares += std::pow(spectrum.density[k] * 0.5 * rate - 1.0, 2);
      tally.covered += spectrum.lower[k] <= 2.0 / rate && spectrum.upper[k] >= 2.0 / rate ? 1.0 : 0.0;
      tally.edf += spectrum.edf[k];
      ++tally.count;
    }
  }
  tally.mean /= tally.count;
  tally.squares /= tally.count;
  tally.covered /= tally.count;
  tally.edf /= tally.count;
  tally.samples = static_cast<double>(samples * records);
  return tally;
}

/// Level to 4 sd of the mean over all records, whose relative sd is sqrt(2/samples), taken twice for points that are
/// averaged over few frequencies; limits to 4 sd of a binomial of 8 independent points a record.
void expect_honest(const Tally& tally) {
  EXPECT_NEAR(tally.mean, 1.0, 4.0 * std::sqrt(2.0 / tally.samples) * 2.0);
  EXPECT_NEAR(tally.covered, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / (8.0 * 250.0)));
}

TEST(PowerSpectrumCoverage, WelchHasTheWhiteLevelAndLimitsThatHold) {
  const auto plain = tally(SpectrumEstimator::welch, {.length = 256}, 0);
  expect_honest(plain);
  EXPECT_NEAR(plain.edf, 36.0 * 225.0 / (19.0 * 15.0 - 1.0), 0.01);  // Percival and Walden (1993), of 15 segments
  EXPECT_NEAR(plain.squares, 2.0 / plain.edf, 0.1 / plain.edf);
  expect_honest(tally(SpectrumEstimator::welch, {.length = 256, .points_per_decade = 5.0}, 0));
  expect_honest(tally(SpectrumEstimator::welch, {.length = 128, .points_per_decade = 5.0}, 20));
}

TEST(PowerSpectrumCoverage, MultitaperHasTheWhiteLevelAndLimitsThatHold) {
  const auto plain = tally(SpectrumEstimator::multitaper, {.adaptive = false}, 0);
  expect_honest(plain);
  EXPECT_NEAR(plain.edf, 14.0, 1e-6);  // 2 K, K = 2 NW - 1
  EXPECT_NEAR(plain.squares, 2.0 / plain.edf, 0.1 / plain.edf);
  expect_honest(tally(SpectrumEstimator::multitaper, {.time_bandwidth = 3.0, .points_per_decade = 5.0}, 0));
}

// On white noise every taper counts alike but for its share beyond the bandwidth, 0.006 of the last: edf 14 less 0.1 %.
TEST(PowerSpectrum, AdaptiveWeightsOfWhiteNoiseAreEven) {
  const auto adaptive = tally(SpectrumEstimator::multitaper, {}, 0);
  expect_honest(adaptive);
  EXPECT_NEAR(adaptive.edf, 14.0, 0.05);
  expect_honest(tally(SpectrumEstimator::multitaper, {.time_bandwidth = 3.0, .points_per_decade = 5.0}, 0));
}

/// White noise through three low-pass filters of first order, and what its density is.
constexpr double pole = 0.9;

std::vector<double> steep(std::uint64_t seed, std::size_t samples) {
  std::vector<double> values = white(seed, samples + 400);
  for (int pass = 0; pass < 3; ++pass) {
    double state = 0.0;
    for (double& value : values) value = state = pole * state + (1.0 - pole) * value;
  }
  return {values.begin() + 400, values.end()};
}

double steep_density(double frequency) {
  const double w = 2.0 * std::numbers::pi * frequency / rate;
  const double one = std::pow(1.0 - pole, 2) / (1.0 - 2.0 * pole * std::cos(w) + pole * pole);
  return 2.0 / rate * one * one * one;
}

// 7.7 decades from end to end: in the upper half of the frequencies what the last tapers let in from below exceeds the
// density itself (with even weights by a factor of 180); the weights keep it out.
TEST(PowerSpectrum, AdaptiveWeightsKeepLeakageOutOfASteepSpectrum) {
  constexpr std::uint64_t records = 100;
  double mean[2] = {0.0, 0.0}, covered[2] = {0.0, 0.0}, edf = 0.0, count = 0.0;
  for (std::uint64_t seed = 0; seed < records; ++seed) {
    const auto values = steep(seed, 256);
    for (const bool adaptive : {false, true}) {
      const auto spectrum =
          power_spectrum(SpectrumEstimator::multitaper, values, rate, {.time_bandwidth = 4.0, .adaptive = adaptive});
      for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
        if (spectrum.frequency[k] < 0.25 * rate) continue;
        const double truth = steep_density(spectrum.frequency[k]);
        mean[adaptive] += spectrum.density[k] / truth;
        covered[adaptive] += spectrum.lower[k] <= truth && truth <= spectrum.upper[k] ? 1.0 : 0.0;
        edf += adaptive ? spectrum.edf[k] : 0.0;
        count += adaptive ? 1.0 : 0.0;
      }
    }
  }
  EXPECT_GT(mean[0] / count, 2.0);
  EXPECT_LT(covered[0] / count, 0.7);
  // 8 points in the bandwidth, 60 in the range: 7 independent ones a record, of relative sd sqrt(2/edf).
  EXPECT_NEAR(mean[1] / count, 1.0, 4.0 * std::sqrt(2.0 / (edf / count) / (7.0 * records)));
  EXPECT_NEAR(covered[1] / count, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / (7.0 * records)));
  EXPECT_LT(edf / count, 13.0);
}

// A random walk and a line 2.7 decades above it: above twice the line's frequency even weights leave 1.37 of the walk.
TEST(PowerSpectrum, AdaptiveWeightsKeepALineOutOfARandomWalk) {
  constexpr std::uint64_t records = 100;
  double mean[2] = {0.0, 0.0}, covered[2] = {0.0, 0.0}, count = 0.0;
  for (std::uint64_t seed = 0; seed < records; ++seed) {
    auto values = white(seed, 512);
    for (std::size_t i = 1; i < values.size(); ++i) values[i] += values[i - 1];
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] += 30.0 * std::sin(0.2 * std::numbers::pi * static_cast<double>(i) + static_cast<double>(seed));
    for (const bool adaptive : {false, true}) {
      const auto spectrum = power_spectrum(SpectrumEstimator::multitaper, values, rate, {.adaptive = adaptive});
      for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
        if (spectrum.frequency[k] < 0.2 * rate) continue;
        const double truth = 0.5 / rate / std::pow(std::sin(std::numbers::pi * spectrum.frequency[k] / rate), 2);
        mean[adaptive] += spectrum.density[k] / truth;
        covered[adaptive] += spectrum.lower[k] <= truth && truth <= spectrum.upper[k] ? 1.0 : 0.0;
        count += adaptive ? 1.0 : 0.0;
      }
    }
  }
  // 8 points in the bandwidth, 150 in the range: 18 independent ones a record, of relative sd sqrt(2/9).
  EXPECT_GT(mean[0] / count, 1.2);
  EXPECT_LT(covered[0] / count, 0.9);
  EXPECT_NEAR(mean[1] / count, 1.0, 4.0 * std::sqrt(2.0 / 9.0 / (18.0 * records)));
  EXPECT_NEAR(covered[1] / count, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / (18.0 * records)));
}

// Parseval: the integral over all frequencies is the mean square. A sine of amplitude a on a bin gives a^2/2, whose
// window keeps it within the bandwidth but for 1e-4 (Hann sidelobes, and 1e-3 of the last Slepian tapers); the slope of
// the line that a sine has about a segment takes 6/(pi k)^2 of it, k = 40 cycles: 4e-4.
TEST(PowerSpectrum, HoldsThePowerOfASineAndASlopeAddsNone) {
  std::vector<double> values(4096);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = 3.0 * std::sin(2.0 * std::numbers::pi * 40.0 / 512.0 * static_cast<double>(i)) +
                100.0 * static_cast<double>(i) - 1e6;
  for (const auto estimator : {SpectrumEstimator::welch, SpectrumEstimator::multitaper}) {
    const auto spectrum = power_spectrum(estimator, values, rate, {.length = 512, .adaptive = false});
    double power = 0.0;
    for (const double density : spectrum.density) power += density * rate / 512.0;
    EXPECT_NEAR(power, 4.5, 4.5 * 3e-3);
  }
}

TEST(PowerSpectrum, LeavesOutWhatStandsBetweenGaps) {
  auto values = white(3, 1000);
  for (const std::size_t i : {100u, 130u, 700u}) values[i] = std::numeric_limits<double>::quiet_NaN();
  const auto spectrum = power_spectrum(SpectrumEstimator::welch, values, rate, {.length = 64});
  // Runs of 100, 29, 569 and 299: 2, 0, 16 and 8 segments that reach 96, 0, 544 and 288 samples.
  EXPECT_EQ(spectrum.segments, 26u);
  EXPECT_EQ(spectrum.left_out, 4u + 29u + 25u + 11u);
}

TEST(PowerSpectrum, RefusesWhatItCannotUse) {
  const auto values = white(3, 100);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"101", "100"}},
                      [&] { power_spectrum(SpectrumEstimator::welch, values, rate, {.length = 101}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"16", "15"}},
                      [&] { power_spectrum(SpectrumEstimator::welch, std::span(values).first(15), rate, {}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, {{.pattern = "sampling rate"}, {.pattern = "confidence"}},
                      [&] { power_spectrum(SpectrumEstimator::multitaper, values, 0.0, {.confidence = 1.0}); }));
  auto broken = values;
  broken[7] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"7"}, .pattern = "infinite"},
                      [&] { power_spectrum(SpectrumEstimator::welch, broken, rate, {}); }));
}

}  // namespace
}  // namespace tumble::power_spectrum_test
