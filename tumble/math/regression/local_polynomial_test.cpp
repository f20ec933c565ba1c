#include "tumble/math/regression/local_polynomial.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr double rate = 500.0, low = 1.0, high = 100.0;

/// Logarithmic sweep of unit amplitude.
std::vector<double> sweep(std::size_t samples) {
  const double time = static_cast<double>(samples) / rate, growth = std::log(high / low);
  std::vector<double> x;
  for (std::size_t i = 0; i < samples; ++i)
    x.push_back(std::sin(two_pi * low * time / growth * std::expm1(static_cast<double>(i) / rate / time * growth)));
  return x;
}

/// y_n = a y_(n-1) + b y_(n-2) + (1 - a - b) x_n: a resonance near 40 Hz; its exact response.
constexpr double a = 1.5, b = -0.7;
std::vector<double> filtered(const std::vector<double>& x) {
  std::vector<double> y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    y[i] = (i > 0 ? a * y[i - 1] : 0.0) + (i > 1 ? b * y[i - 2] : 0.0) + (1.0 - a - b) * x[i];
  return y;
}
std::complex<double> exact(double f) {
  const auto z = std::polar(1.0, -two_pi * f / rate);
  return (1.0 - a - b) / (1.0 - a * z - b * z * z);
}

const std::vector<double> frequencies{2.0, 5.0, 12.5, 31.5, 63.0, 80.0};

TEST(LocalPolynomialResponse, NoiseFreeSweepThroughAKnownFilter) {
  const auto x = sweep(30000), y = filtered(x);
  for (const auto& band : local_polynomial_response(x, rate, y, rate, frequencies, low, high, 0.115)) {
    ASSERT_TRUE(band.found) << band.frequency;
    // Remainder of the fifth order of a resonance of half width 20 Hz over +-11.5 %, and the leakage beyond a
    // quadratic.
    EXPECT_NEAR(std::abs(band.response / exact(band.frequency) - 1.0), 0.0, 2e-4) << band.frequency;
    EXPECT_GT(band.coherence, 0.9999);
  }
}

TEST(LocalPolynomialResponseCoverage, UncertaintiesHold) {
  constexpr int seeds = 100;
  const auto x = sweep(15000), clean = filtered(x);
  std::vector<double> gain(frequencies.size(), 0.0), phase(frequencies.size(), 0.0);
  double expected = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    auto y = clean;
    std::vector<double> noise(y.size());
    RandomStream(static_cast<std::uint64_t>(seed)).normal(0, noise);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += 0.1 * noise[i];
    const auto bands = local_polynomial_response(x, rate, y, rate, frequencies, low, high, 0.115);
    for (std::size_t k = 0; k < bands.size(); ++k) {
      const auto ratio = bands[k].response / exact(frequencies[k]);
      gain[k] += std::pow(std::log(std::abs(ratio)), 2) / bands[k].variance / seeds;
      phase[k] += std::pow(std::arg(ratio), 2) / bands[k].variance / seeds;
    }
    expected = bands[0].degrees_of_freedom / (bands[0].degrees_of_freedom - 2.0);
  }
  // z^2 of F(1, >= 10): mean up to 1.25, variance up to 6; 4 sigma of a mean of 100: 1.0 there, 0.57 with many.
  for (std::size_t k = 0; k < frequencies.size(); ++k) {
    EXPECT_NEAR(gain[k], k == 0 ? expected : 1.0, k == 0 ? 1.0 : 0.6) << frequencies[k];
    EXPECT_NEAR(phase[k], k == 0 ? expected : 1.0, k == 0 ? 1.0 : 0.6) << frequencies[k];
  }
}

TEST(LocalPolynomialResponse, RefusesUnequalTimes) {
  const std::vector<double> x(1000, 0.0), y(900, 0.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"2", "1.8"}},
                      [&] { local_polynomial_response(x, rate, y, rate, frequencies, low, high, 0.1); }));
}

TEST(LocalPolynomialResponse, LengthsAndOccupiedBand) {
  EXPECT_EQ(smooth_length(1000, 1), 1000u);
  EXPECT_EQ(smooth_length(1001, 1), 1000u);
  EXPECT_EQ(smooth_length(1000, 7), 0u);
  const auto [from, to] = occupied_band(sweep(30000), rate);
  EXPECT_NEAR(from, low, 0.1);
  EXPECT_NEAR(to, high, 5.0);
}

}  // namespace
}  // namespace tumble
