#include "tumble/math/spectrum/spectral_conversion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/math/spectrum/power_spectrum.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double conversion_rate = 10.0, interval = 0.1;

/// From 1e-7 Hz to half the rate, 1 % apart.
std::vector<double> tested_frequencies() {
  std::vector<double> frequency{1e-7};
  while (frequency.back() < 4.95) frequency.push_back(1.01 * frequency.back());
  frequency.push_back(0.5 * conversion_rate);
  return frequency;
}

/// Through the spectrum of samples against the closed form. Power laws between the points miss the curvature of the
/// folded spectrum by less than 3e-5 (second order in 1 %); below 1e-7 Hz the walk's Allan variance lacks 3e-5 at
/// m = 1000: (2 pi f tau)^2 f S of it.
void expect(Stability measure, const NoiseModel& noise, const std::function<double(double)>& closed) {
  const auto frequency = tested_frequencies();
  std::vector<double> density;
  for (const double f : frequency) density.push_back(sampled_density(noise, f, conversion_rate));
  for (const std::size_t m : {1u, 2u, 7u, 64u, 1000u}) {
    const double expected = closed(static_cast<double>(m));
    EXPECT_NEAR(stability_variance_from_spectrum(measure, frequency, density, conversion_rate, m), expected,
                6e-5 * expected)
        << m;
  }
}

TEST(SpectralConversion, GivesTheVariancesOfPowerLaws) {
  // White samples of variance N^2/T: 1/m of it, (m^2 + 1)/(2 m^3), 1/m.
  const NoiseModel white{.angle_random_walk = 1.0};
  expect(Stability::allan, white, [](double m) { return 1.0 / (m * interval); });
  expect(Stability::modified_allan, white, [](double m) { return (m * m + 1.0) / (2.0 * m * m * m * interval); });
  expect(Stability::overlapping_hadamard, white, [](double m) { return 1.0 / (m * interval); });
  const NoiseModel quantization{.quantization_noise = 1.0};
  expect(Stability::allan, quantization, [](double m) { return 3.0 / std::pow(m * interval, 2); });
  expect(Stability::modified_allan, quantization, [](double m) { return 3.0 / (m * std::pow(m * interval, 2)); });
  expect(Stability::hadamard, quantization, [](double m) { return 10.0 / (3.0 * std::pow(m * interval, 2)); });
  const NoiseModel walk{.rate_random_walk = 1.0};
  expect(Stability::allan, walk, [](double m) { return m * interval / 3.0; });
  expect(Stability::hadamard, walk, [](double m) { return m * interval / 6.0; });
  const NoiseModel flicker{.bias_instability = 1.0};
  expect(Stability::allan, flicker, [](double) { return 2.0 * std::numbers::ln2 / std::numbers::pi; });
  const NoiseModel markov{.markov_sd = 1.0, .markov_time = 3.0};
  expect(Stability::allan, markov, [&](double m) { return expected_allan_variance(markov, m * interval); });
}

TEST(SpectralConversion, SamplesHaveTheContinuousDensityAtLowFrequencies) {
  const NoiseModel noise{.quantization_noise = 0.3,
                         .angle_random_walk = 1.0,
                         .bias_instability = 2.0,
                         .rate_random_walk = 3.0,
                         .markov_sd = 1.0,
                         .markov_time = 3.0};
  // sinc^2 takes (pi f T)^2/3 = 3e-7, aliases of the walk add 2 (f T)^2 zeta(2).. of it.
  const double continuous = continuous_density(noise, 0.003, conversion_rate);
  EXPECT_NEAR(sampled_density(noise, 0.003, conversion_rate), continuous, 1e-4 * continuous);
  EXPECT_NEAR(continuous_density({.angle_random_walk = 1.0}, 1.0, conversion_rate), 2.0, 1e-15);  // one-sided
}

// The measured spectrum of simulated noise, every frequency alike, gives the measured Allan variance. Of 65536 samples,
// the variance at m = 1 ... 64 has a relative sd of sqrt(3 m/N) and less: 5.4 %; both come from the same record.
TEST(SpectralConversion, AMeasuredSpectrumGivesTheMeasuredDeviation) {
  std::vector<double> values(65536, 0.0);
  add_noise({.quantization_noise = 0.05, .angle_random_walk = 1.0, .rate_random_walk = 0.05}, conversion_rate,
            RandomStream(5), values);
  const std::vector<std::size_t> factors{1, 4, 16, 64};
  const auto measured = stability_of_rate(Stability::overlapping_allan, values, interval, factors, {});
  const auto spectrum = power_spectrum(SpectrumEstimator::multitaper, values, conversion_rate, {});
  for (const auto& point : measured) {
    const double variance = stability_variance_from_spectrum(Stability::overlapping_allan, spectrum.frequency,
                                                             spectrum.density, conversion_rate, point.factor);
    EXPECT_NEAR(variance, point.deviation * point.deviation, 0.02 * variance) << point.factor;
  }
}

TEST(SpectralConversion, RefusesWhatItCannotUse) {
  const std::vector<double> frequency{1.0, 2.0}, density{1.0, 1.0};
  EXPECT_TRUE(refuses(Error::Kind::unsupported, Asked{.pattern = "Allan, modified Allan and Hadamard"},
                      [&] { stability_transfer(Stability::total, 0.1, 1); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"1"}, .pattern = "ascend"}, [&] {
    stability_variance_from_spectrum(Stability::allan, density, density, conversion_rate, 1);
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, {{.pattern = "averaging factor"}, {.values = {"1"}, .pattern = "ascend"}},
                      [&] { stability_variance_from_spectrum(Stability::allan, frequency, density, 3.0, 0); }));
}

}  // namespace
}  // namespace tumble
