#include "tumble/reduce/pulses/rounding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/models/model.hpp"

namespace tumble::pulses {
namespace {

constexpr double pi = std::numbers::pi;

/// Force in each window: constant plus a sine, in pulses a window.
double force(double constant, double amplitude, double cycles, std::size_t window) {
  return constant + amplitude * std::cos(2.0 * pi * cycles * (static_cast<double>(window) + 0.5) + 0.3);
}

/// What the counter of the model makes of it (3.3): windows of 1 s, one pulse for 1 m/s.
std::vector<double> counted(double constant, double amplitude, double cycles, std::uint64_t start, std::size_t count) {
  const Model& model = find_model("pendulous_accelerometer");
  Settings truth = defaults(truth_options(model));
  truth.set_word("output", "count");
  truth.set_number("pulse_scale_factor", 1.0, Unit::parse("pulse/s/g"));
  std::vector<double> samples(count);
  for (std::size_t j = 0; j < count; ++j) samples[j] = force(constant, amplitude, cycles, j);
  model.record(truth, 0, 1.0, RandomStream(start)).response(samples);
  return samples;
}

/// Variance and correlation of neighbours of what rounding does to each window [pulse^2], and of it all together.
struct Rounding {
  double variance = 0.0, correlation = 0.0, total = 0.0;
};

Rounding rounding_of(double constant, double amplitude, double cycles, std::uint64_t start) {
  constexpr std::size_t n = 4000;
  const auto whole = counted(constant, amplitude, cycles, start, n);
  Rounding r;
  std::vector<double> error(n);
  for (std::size_t j = 0; j < n; ++j) {
    EXPECT_EQ(whole[j], std::round(whole[j]));
    error[j] = whole[j] - force(constant, amplitude, cycles, j);
    r.total += error[j];
  }
  for (std::size_t j = 0; j < n; ++j) r.variance += error[j] * error[j] / n;
  for (std::size_t j = 1; j < n; ++j) r.correlation += error[j] * error[j - 1] / n / r.variance;
  return r;
}

// Constant input, p the fraction of a pulse in each window: variance p(1 - p), neighbours -min(p, 1-p)/max(p, 1-p).
// 4000 windows hold whole periods of these fractions; ends of the record: 1/4000.
TEST(Counting, RoundingOfAConstantInput) {
  double mean = 0.0;
  for (int k = 1; k < 20; ++k) {
    const double p = k / 20.0;
    const auto r = rounding_of(100.0 + p, 0.0, 0.0, 3);
    EXPECT_NEAR(r.variance, p * (1.0 - p), 1e-3) << p;
    EXPECT_NEAR(r.correlation, -std::min(p, 1.0 - p) / std::max(p, 1.0 - p), 2e-3) << p;
    EXPECT_LE(std::abs(r.total), 1.0 + 1e-9);
    mean += r.variance / 20.0;
  }
  EXPECT_NEAR(mean, pulses::rounding_variance(1.0, 1.0),
              1e-3);  // the trapezoidal rule of p(1-p) over 20 parts: 1/6 - 1/2400
  EXPECT_NEAR(rounding_of(100.0, 0.0, 0.0, 3).variance, 0.0, 1e-12);  // no spread at all
}

// A sine on the 10 Hz raster repeats every 20 windows or fewer: the variance is anything from well below 1/6 pulse^2 to
// well above. The total stays within a pulse.
TEST(Counting, RoundingOfASineOnTheRaster) {
  double least = 1.0, most = 0.0;
  const RandomStream random(9);
  for (std::uint64_t k = 0; k < 300; ++k) {
    const double constant = 60.0 + std::floor(20.0 * random.uniform(4 * k)) / 20.0;
    const double amplitude = 100.0 + 50.0 * random.uniform(4 * k + 1);
    const double cycles = 0.05 * std::ceil(9.0 * random.uniform(4 * k + 2));
    const auto r = rounding_of(constant, amplitude, cycles, k);
    least = std::min(least, r.variance);
    most = std::max(most, r.variance);
    EXPECT_LE(std::abs(r.total), 1.0 + 1e-6);
  }
  EXPECT_LT(least, 0.1);
  EXPECT_GT(most, 0.28);
  EXPECT_LT(most, 1.0);  // no window is off by more than a pulse
}

}  // namespace
}  // namespace tumble::pulses
