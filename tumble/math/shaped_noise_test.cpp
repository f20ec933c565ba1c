#include "tumble/math/shaped_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <thread>
#include <unsupported/Eigen/FFT>

namespace tumble {
namespace {

std::vector<double> values(const ShapedNoise& noise, double first, double step, std::size_t count) {
  std::vector<double> out(count);
  noise.values(first, step, out);
  return out;
}

TEST(SpectralDensity, StraightLinesBetweenThePointsOnLogarithmicScales) {
  const SpectralDensity psd{{20.0, 80.0, 350.0, 2000.0},
                            {0.01, 0.04, 0.04, 0.007}};  // +3 dB/octave, flat, -3 dB/octave
  EXPECT_NEAR(density_at(psd, 40.0), 0.02, 1e-15);
  EXPECT_NEAR(density_at(psd, 200.0), 0.04, 1e-15);
  EXPECT_NEAR(density_at(psd, 700.0), 0.02, 1e-15);
  EXPECT_NEAR(density_at(psd, 20.0), 0.01, 1e-15);
  EXPECT_NEAR(density_at(psd, 2000.0), 0.007, 1e-15);
  EXPECT_EQ(density_at(psd, 19.9), 0.0);
  EXPECT_EQ(density_at(psd, 2000.1), 0.0);
}

TEST(SpectralDensity, VarianceInClosedFormIsItsIntegral) {
  EXPECT_NEAR(std::sqrt(variance({{20.0, 2000.0}, {0.1, 0.1}})), std::sqrt(0.1 * 1980.0), 1e-12);
  EXPECT_NEAR(variance({{10.0, 1000.0}, {1.0, 0.01}}), 10.0 * std::log(100.0), 1e-12);  // 1/f
  const SpectralDensity psd{{20.0, 80.0, 350.0, 2000.0}, {0.01, 0.04, 0.04, 0.007}};
  // by hand: 0.01/20 (80^2 - 20^2)/2 + 0.04 270 + 14 ln(2000/350)
  EXPECT_NEAR(variance(psd), 1.5 + 10.8 + 14.0 * std::log(2000.0 / 350.0), 1e-10);
}

/// One-sided density of a signal by averaged periodograms of `size` samples, Hann window, no overlap.
std::vector<double> periodogram(const std::vector<double>& x, double rate, std::size_t size) {
  Eigen::FFT<double> fft;
  std::vector<double> density(size / 2 + 1), part(size);
  const std::size_t parts = x.size() / size;
  for (std::size_t p = 0; p < parts; ++p) {
    for (std::size_t i = 0; i < size; ++i)
      part[i] = x[p * size + i] *
                (1.0 - std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(size)));
    std::vector<std::complex<double>> spectrum;
    fft.fwd(spectrum, part);
    for (std::size_t k = 0; k < density.size(); ++k)
      density[k] += 2.0 * std::norm(spectrum[k]) / (1.5 * static_cast<double>(size * parts) * rate);
  }
  return density;
}

// Bands of 20 lines of 400 periodograms: neighbouring lines of a Hann window are correlated (their sum has the variance
// of about half as many), relative sd sqrt(2/(20 400)) = 0.016; 4 sigma. Lines of 1.25 Hz; 40 Hz away from points and
// edges.
TEST(ShapedNoise, HasItsDensityAtAnyRate) {
  const SpectralDensity psd{{100.0, 400.0, 1000.0, 2000.0}, {0.01, 0.04, 0.04, 0.01}};
  const ShapedNoise noise(psd, RandomStream(5));
  for (const double rate : {5000.0, 10240.0, 23456.7}) {
    const std::size_t size = 8192;
    const double line = rate / static_cast<double>(size);
    const auto density = periodogram(values(noise, 0.3 / rate, 1.0 / rate, size * 100), rate, size);
    for (std::size_t k = 0; k + 20 < density.size(); k += 20) {
      double measured = 0.0, expected = 0.0;
      bool clear = true;
      for (std::size_t j = k; j < k + 20; ++j) {
        const double f = line * static_cast<double>(j);
        measured += density[j] / 20.0;
        expected += density_at(psd, f) / 20.0;
        for (const double point : psd.frequency) clear = clear && std::abs(f - point) > 40.0;
      }
      if (!clear) continue;
      const double f = line * static_cast<double>(k);
      if (expected > 0.0)
        EXPECT_NEAR(measured / expected, 1.0, 4.0 * 0.032) << rate << " Hz, at " << f;
      else
        EXPECT_LT(measured, 1e-6) << rate << " Hz, at " << f;  // images, and leakage of the windows
    }
  }
}

// The variance at single instants is the same, wherever between the coefficients (12 kHz apart 83 us) and the blocks
// they lie: 20000 independent values each, relative sd of a variance 0.01; 4 sigma.
TEST(ShapedNoise, IsStationary) {
  const SpectralDensity psd{{500.0, 2000.0}, {2.0, 2.0}};
  EXPECT_NEAR(variance(psd), 3000.0, 1e-9);
  const ShapedNoise noise(psd, RandomStream(6));
  for (const double offset : {0.0, 20.8e-6, 41.7e-6, 62.5e-6}) {
    const auto x = values(noise, 0.01 + offset, 1.0 / 120.0, 20000);  // 100 coefficients apart
    double sum = 0.0, fourth = 0.0;
    for (const double v : x) {
      sum += v * v / 20000.0;
      fourth += v * v * v * v / 20000.0;
    }
    EXPECT_NEAR(sum / 3000.0, 1.0, 4.0 * std::sqrt(2.0 / 20000.0)) << offset;
    // Gaussian: kurtosis 3, sd sqrt(24/20000)
    EXPECT_NEAR(fourth / (sum * sum), 3.0, 4.0 * 0.035) << offset;
  }
}

TEST(ShapedNoise, IsOneFunctionOfTime) {
  const ShapedNoise noise({{20.0, 200.0}, {1.0, 1.0}}, RandomStream(7));
  const double step = 1.0 / 1024.0;
  const auto whole = values(noise, 0.0, step, 100000);
  // any block, backwards, by several threads, from another object
  const ShapedNoise again({{20.0, 200.0}, {1.0, 1.0}}, RandomStream(7));
  std::vector<std::thread> threads;
  std::vector<double> other(whole.size());
  for (std::size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (std::size_t b = 100; b-- > 0;)
        if (b % 4 == t)
          again.values(static_cast<double>(b * 1000) * step, step, std::span(other).subspan(b * 1000, 1000));
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(whole, other);
  // finer steps pass through the same values, which are far apart from others of another stream
  const auto fine = values(noise, 0.0, step / 64.0, 64000);
  for (std::size_t i = 0; i < 1000; ++i) EXPECT_EQ(fine[64 * i], whole[i]);
  EXPECT_NE(values(ShapedNoise({{20.0, 200.0}, {1.0, 1.0}}, RandomStream(8)), 0.0, step, 10),
            values(noise, 0.0, step, 10));
}

// Central differences, h = 10 us: h^2/6 x''' < 1.7e-11 (2 pi 200)^3 4 sd = 2e-6 sd; the second h^2/12 x'''' and
// rounding.
TEST(ShapedNoise, DerivativesAreThoseOfTheValue) {
  const ShapedNoise noise({{20.0, 200.0}, {1.0, 1.0}}, RandomStream(9));
  const double h = 1e-5, sd = std::sqrt(180.0), w = 2.0 * std::numbers::pi * 200.0;
  for (int i = 0; i < 200; ++i) {
    const double time = 0.1 + 0.0137 * i;
    const auto a = noise.at(time - h), b = noise.at(time), c = noise.at(time + h);
    EXPECT_EQ(values(noise, time, 1.0, 1)[0], b.value);
    EXPECT_NEAR((c.value - a.value) / (2.0 * h), b.first_derivative, h * h * w * w * w * sd);
    EXPECT_NEAR((c.first_derivative - a.first_derivative) / (2.0 * h), b.second_derivative, h * h * w * w * w * w * sd);
  }
}

}  // namespace
}  // namespace tumble
