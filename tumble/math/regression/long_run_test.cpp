#include "tumble/math/regression/long_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/math/shaped_noise.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::vector<double> white(std::size_t n, std::uint64_t seed) {
  std::vector<double> out(n);
  RandomStream(seed).normal(0, out);
  return out;
}

DensityAtZero density_of(const std::vector<double>& values, bool slow = false) {
  return long_run({values}, 0.02, slow).density.front();
}

// White noise of variance 4: the mean over the seeds of the density, and its stated variance, are right. 60 seeds with
// 400 ordinates: each known to 2/sqrt(400) (blue takes some of it) of 4, the mean over 60 to below 2 %; 4 sigma.
TEST(LongRun, WhiteNoise) {
  double sum = 0.0, squares = 0.0, stated = 0.0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    auto x = white(10'000, seed);
    for (double& v : x) v = 2.0 * v + 7.0;
    const auto density = density_of(x);
    sum += density.white;
    squares += density.white * density.white;
    stated += density.covariance(0, 0);
  }
  const double mean = sum / 60.0, variance = squares / 60.0 - mean * mean;
  EXPECT_NEAR(mean, 4.0, 4.0 * std::sqrt(variance / 60.0) + 0.02);
  EXPECT_NEAR(variance / (stated / 60.0), 1.0, 4.0 * std::sqrt(2.0 / 59.0));
}

// Successive differences of numbers of variance 1/12: density sin^2(pi f)/3, (pi^2/3) f^2 towards zero; the sum over
// all is off by two of them.
TEST(LongRun, RoundingOfCountsIsBlue) {
  const RandomStream random(5);
  std::vector<double> x(20'000);
  for (std::size_t j = 0; j < x.size(); ++j) x[j] = random.uniform(j + 1) - random.uniform(j);
  const auto density = density_of(x);
  const double expected = std::numbers::pi * std::numbers::pi / 3.0;
  EXPECT_NEAR(density.blue / expected, 1.0, 4.0 * std::sqrt(2.0 / 800.0) * 1.5);
  EXPECT_LT(density.white, 1e-4);  // of 1/6, were it white
  const auto sum = variance_of_sum(density, std::vector<double>(x.size(), 1.0));
  EXPECT_NEAR(sum.variance, 1.0 / 6.0 + density.white * 20'000.0, 0.05);
}

// Acceleration of 0.1 g^2/Hz between 20 and 2000 Hz, windows of 5 ms, 40 s: a plain mean is off by the velocities at
// both ends, sqrt(S/(2 pi^2 T^2 20 Hz)) (3.13); one that fades by a twentieth of that, and says so.
TEST(LongRun, FadedMeanOfMotionForgetsTheVelocities) {
  constexpr std::size_t windows = 8000, steps = 25, seeds = 60;
  const double h = 0.005, time = windows * h;
  const auto weights = faded_weights(windows, 0.1);
  double plain = 0.0, faded = 0.0, stated = 0.0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    std::vector<double> fine(windows * steps), x(windows, 0.0);
    ShapedNoise({{20.0, 2000.0}, {0.1, 0.1}}, RandomStream(seed)).values(1e-4, h / steps, fine);
    for (std::size_t i = 0; i < fine.size(); ++i) x[i / steps] += fine[i] / steps;
    double mean = 0.0, other = 0.0;
    for (std::size_t j = 0; j < windows; ++j) mean += x[j] / windows, other += weights[j] * x[j];
    plain += mean * mean / seeds;
    faded += other * other / seeds;
    auto density = density_of(x);
    density.white = 0.0;
    density.covariance = Matrix(3, 3);
    density.covariance(1, 1) = 1.0;
    stated += variance_of_sum(density, weights).variance / seeds;
  }
  const double expected = std::sqrt(0.1 / (2.0 * std::numbers::pi * std::numbers::pi * time * time * 20.0));
  const double of_sixty = 4.0 / std::sqrt(2.0 * seeds);            // 4 sigma, relative, of an rms over the seeds
  EXPECT_NEAR(std::sqrt(plain) / expected, 1.0, of_sixty + 0.02);  // the edge at 20 Hz is smoothed: 1.3 % less
  EXPECT_LT(std::sqrt(faded), 0.05 * expected);
  EXPECT_NEAR(std::sqrt(faded / stated), 1.0, of_sixty);
}

// A mean and another that shares half of its variance.
TEST(LongRun, Correlation) {
  const auto a = white(20'000, 1), other = white(20'000, 2);
  auto b = a;
  for (std::size_t j = 0; j < b.size(); ++j) b[j] = (a[j] + other[j]) / std::numbers::sqrt2;
  const auto run = long_run({a, b}, 0.02, false);
  EXPECT_NEAR(run.correlation(0, 1), std::sqrt(0.5), 4.0 * 0.5 / std::sqrt(40.0));
  EXPECT_EQ(run.correlation(0, 0), 1.0);
}

// Two means that follow each other differ by 8 ln 2 for the density 1/f: twice the Allan variance 2 ln 2 h of a
// one-sided density h/f = 2/f.
TEST(LongRun, SlowGain) {
  EXPECT_NEAR(slow_gain(std::vector<WeightedSpan>{{0.0, 1.0, 1.0}, {1.0, 2.0, -1.0}}), 8.0 * std::numbers::ln2, 1e-12);
  EXPECT_NEAR(slow_gain(std::vector<WeightedSpan>{{5.0, 65.0, 1.0}, {65.0, 125.0, -1.0}}), 8.0 * std::numbers::ln2,
              1e-9);
}

TEST(LongRun, SlowNoiseIsFoundAndWhiteNoiseHasNone) {
  auto x = white(20'000, 3);
  EXPECT_EQ(density_of(x, true).slow, 0.0);
  double walk = 0.0;
  const auto steps = white(20'000, 4);
  for (std::size_t j = 0; j < x.size(); ++j) x[j] += walk = 0.999 * walk + 0.1 * steps[j];
  EXPECT_GT(density_of(x, true).slow, 0.0);
}

TEST(LongRun, MissingSamplesAndNothingAtAll) {
  auto x = white(5000, 6);
  for (std::size_t j = 100; j < 200; ++j) x[j] = NAN;
  // 200 ordinates, of which a part that grows with f^2 takes its share: a variance of 2/200 times 1/(1 - 5/9). Of the
  // samples 2 % are missing. 4 sigma.
  EXPECT_NEAR(density_of(x).white, 1.0, 4.0 * std::sqrt(2.0 / 200.0 * 9.0 / 4.0) + 0.02);
  EXPECT_LT(density_of(std::vector<double>(100, 3.0)).white, 1e-20);
  EXPECT_LT(variance_of_sum(density_of(std::vector<double>(100, 3.0)), faded_weights(100, 0.1)).variance, 1e-20);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "fewer than 64 samples"},
                      [&] { density_of(std::vector<double>(63, 1.0)); }));
}

TEST(LongRun, FadedWeights) {
  const auto weights = faded_weights(1000, 0.1);
  double sum = 0.0;
  for (const double w : weights) sum += w;
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_LT(weights.front(), 1e-4 * weights[500]);
  EXPECT_EQ(weights[100], weights[899]);
  EXPECT_DOUBLE_EQ(faded_weights(4, 0.0)[0], 0.25);
}

}  // namespace
}  // namespace tumble
