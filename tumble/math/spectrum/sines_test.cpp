#include "tumble/math/spectrum/sines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/noise_model.hpp"

namespace tumble::sines_test {
namespace {

constexpr double turn = 2.0 * std::numbers::pi;

std::vector<double> white_samples(std::size_t samples, std::uint64_t seed) {
  std::vector<double> values(samples, 3.0);
  add_noise({.angle_random_walk = 1.0}, 1.0, RandomStream(seed), values);
  return values;
}

void put(double amplitude, double frequency, double phase, std::vector<double>& values) {
  for (std::size_t n = 0; n < values.size(); ++n)
    values[n] += amplitude * std::cos(turn * frequency * static_cast<double>(n) + phase);
}

double unit_level(double) { return 1.0; }

TEST(Sines, HasTheScatterOfTheBoundAndIntervalsThatHold) {
  // 200 records of 8000 samples, anywhere between two frequencies of a transform, with 5 % missing in the middle of
  // some. A standard deviation is known to 1/sqrt(400) of itself.
  constexpr double amplitude = 0.3, samples = 8000.0;
  constexpr int records = 200;
  double held_a = 0.0, held_f = 0.0, off_a = 0.0, off_f = 0.0;
  for (unsigned seed = 1; seed <= records; ++seed) {
    const double frequency = 0.0711 + 0.37 * seed / samples;
    auto values = white_samples(static_cast<std::size_t>(samples), seed);
    put(amplitude, frequency, seed, values);
    Sines sines(values);
    sines.add(frequency + 1e-4, 5e-4);
    sines.refine();
    const SineQuality quality = sines.quality(0, unit_level);
    // At the bound but for the taper over 57 samples at either end and what is known of the level: 3 sd of 12 %.
    EXPECT_NEAR(quality.amplitude_sd, std::sqrt(2.0 / samples), 0.2 * std::sqrt(2.0 / samples));
    EXPECT_NEAR(quality.frequency_sd, std::sqrt(24.0 / std::pow(samples, 3)) / (turn * amplitude),
                0.3 * quality.frequency_sd);
    const double a = (std::abs(sines.all()[0].amplitude) - amplitude) / quality.amplitude_sd;
    const double f = (sines.all()[0].frequency - frequency) / quality.frequency_sd;
    held_a += std::abs(a) < 1.96 ? 1.0 / records : 0.0;
    held_f += std::abs(f) < 1.96 ? 1.0 / records : 0.0;
    off_a += a / records;
    off_f += f / records;
  }
  const double four_sd = 4.0 * std::sqrt(0.95 * 0.05 / records);
  EXPECT_NEAR(held_a, 0.95, four_sd);
  EXPECT_NEAR(held_f, 0.95, four_sd);
  EXPECT_LT(std::abs(off_a), 4.0 / std::sqrt(1.0 * records));
  EXPECT_LT(std::abs(off_f), 4.0 / std::sqrt(1.0 * records));
}

TEST(Sines, SeveralOfVeryDifferentSizeBesideDriftAndGaps) {
  // Without noise: what is left is the leakage of drift and of the others, 1e-6 of the strongest.
  std::vector<double> values(20000, 9.8);
  const double frequencies[] = {0.05003, 0.10006, 0.2301, 12.3 / 20000}, amplitudes[] = {100.0, 1.0, 0.01, 0.1};
  for (std::size_t i = 0; i < 4; ++i) put(amplitudes[i], frequencies[i], 1.0 + static_cast<double>(i), values);
  for (std::size_t n = 0; n < values.size(); ++n) values[n] += 1e-5 * static_cast<double>(n);
  for (std::size_t n = 7000; n < 8000; ++n) values[n] = std::nan("");
  for (std::size_t n = 0; n < values.size(); n += 997) values[n] = std::nan("");
  Sines sines(values);
  for (const double frequency : frequencies) sines.add(frequency + 1.5e-5, 4e-5);
  for (int round = 0; round < 5; ++round) sines.refine();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(sines.all()[i].frequency, frequencies[i], 1e-8) << i;
    EXPECT_NEAR(std::abs(sines.all()[i].amplitude), amplitudes[i], 2e-4) << i;
  }
  sines.remove(1);
  EXPECT_EQ(sines.all().size(), 3u);
  Sines alone(sines.rest());
  alone.add(0.10006, 1e-5);
  EXPECT_NEAR(std::abs(alone.all()[0].amplitude), 1.0, 1e-3);
}

TEST(Sines, DistinguishesASteadySineFromOneThatWanders) {
  // Mean square of 8 parts over what noise makes: chi-square of 13 degrees of freedom over 13, above 3.2 once in 1e4.
  // One that is a quarter of a turn off at either end, one whose amplitude doubles, one that is there half the time.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    auto steady = white_samples(16384, seed), turning = steady, growing = steady, gone = steady;
    put(1.0, 0.1234, 1.0, steady);
    for (std::size_t n = 0; n < steady.size(); ++n) {
      const double t = static_cast<double>(n) / 16384.0 - 0.5, at = turn * 0.1234 * static_cast<double>(n);
      turning[n] += std::cos(at + turn * t * t);
      growing[n] += (1.0 + 2.0 / 3.0 * t) * std::cos(at);
      gone[n] += t < 0.0 ? std::cos(at) : 0.0;
    }
    const auto quality = [](const std::vector<double>& values) {
      Sines sines(values);
      sines.add(0.1234, 5e-4);
      sines.refine();
      return sines.quality(0, unit_level);
    };
    EXPECT_LT(quality(steady).wander, 3.2) << seed;
    EXPECT_GT(quality(turning).wander, 4.0) << seed;
    EXPECT_GT(quality(turning).unsteadiness, 0.3) << seed;
    EXPECT_GT(quality(growing).wander, 4.0) << seed;
    EXPECT_NEAR(quality(growing).unsteadiness, 0.19, 0.04) << seed;  // (2/3)/sqrt(12)
    EXPECT_GT(quality(gone).unsteadiness, 0.9) << seed;
  }
}

TEST(Sines, NoPowerWhereThereIsNone) {
  // The largest of frequencies over 8 bins: exponential of mean 1, above 12 once in 1e4 times 16.
  for (unsigned seed = 1; seed <= 60; ++seed) {
    Sines sines(white_samples(8192, seed));
    sines.add(0.2, 4.0 / 8192.0);
    EXPECT_LT(sines.quality(0, unit_level).power, 12.0) << seed;
  }
}

TEST(Sines, ReturnsWhatItTookOfTheNoise) {
  // A sine of 8.3 periods in white noise: half the taper is Hann's. Within a period of it the mean square of the sines
  // of the bands is below the noise without, as it is with what was taken given back: 200 records of 4 sines and more,
  // 5 % and 4 sigma. About three degrees of freedom are gone.
  double before = 0.0, after = 0.0, count = 0.0, given = 0.0, lost = 0.0;
  constexpr double frequency = 40.3 / 4096.0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto values = white_samples(4096, seed);
    put(2.0, frequency, seed, values);
    Sines sines(values);
    sines.add(frequency, 2.0 / 4096.0);
    sines.refine();
    const NoiseBands taken(sines.rest());
    NoiseBands back = taken;
    std::vector<double> expected;
    for (const NoiseBand& band : taken.bands) expected.push_back(band.expected[1]);
    sines.give_back(expected, unit_level, back);
    const auto sum = [&](const NoiseBands& bands, double& all) {
      double square = 0.0;
      for (const NoiseBand& band : bands.bands)
        if (std::abs(band.frequency - frequency) < 1.5 / 4096.0) {
          square += band.count * band.mean_square / band.expected[1];
          all += band.count;
        }
      return square;
    };
    double all_before = 0.0, all_after = 0.0;
    before += sum(taken, all_before);
    after += sum(back, all_after);
    count += all_before;
    given += all_after;
    double whole = 0.0;
    for (const NoiseBand& band : taken.bands) whole += band.count;
    for (const NoiseBand& band : back.bands) whole -= band.count;
    lost += whole / 200.0;
  }
  EXPECT_LT(before / count, 0.75);
  EXPECT_NEAR(after / given, 1.0, 4.0 * std::sqrt(2.0 / given));
  EXPECT_NEAR(lost, 3.0, 0.5);
}

}  // namespace
}  // namespace tumble::sines_test
