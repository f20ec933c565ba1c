#include "tumble/reduce/coarse_output.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/random.hpp"

namespace tumble {
namespace {

/// Of a test in which every stretch has one true value.
std::optional<CoarseOutput> found_in(const ConductedTest& test) {
  return coarse_output(test, std::vector<bool>(test.stretches.size(), true));
}

/// Stretches of 100 samples, each at a place of its own within a step, with this noise [steps].
struct Rounded {
  ConductedTest test;
  std::vector<double> errors;  ///< of the means, by rounding alone [u]
};

Rounded rounded(double step, double noise, std::size_t stretches, std::uint64_t seed) {
  Rounded out;
  for (std::size_t g = 0; g < stretches; ++g) {
    const RandomStream random = RandomStream(seed).split(g);
    const double level = 3.0 * random.split("level").normal(0);
    std::vector<double> values(100);
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double exact = level + noise * step * random.normal(i);
      values[i] = step * std::round(exact / step);
      sum += (values[i] - exact) / 100.0;
    }
    out.errors.push_back(sum);
    Stretch stretch;
    stretch.values = EvenValues(std::move(values), 1.0);
    out.test.stretches.push_back(std::move(stretch));
  }
  return out;
}

// The rms of 400 errors by rounding is known to 1/sqrt(800) = 3.5 % of itself, 4 sigma 14 %; rounding of single samples
// adds q^2/12/100 to their square, which is what a noise of 0.36 steps leaves of the rest.
TEST(CoarseOutput, RoundingOfMeansAgreesWithSimulation) {
  for (const double noise : {0.0, 0.05, 0.1, 0.2, 0.3}) {
    const Rounded made = rounded(0.013, noise, 400, 12);
    const auto found = found_in(made.test);
    ASSERT_TRUE(found) << noise;
    EXPECT_NEAR(found->step, 0.013, 1e-9) << noise;
    double squares = 0.0;
    for (const double e : made.errors) squares += e * e / 400.0;
    const double own = noise > 0.0 ? 0.013 * 0.013 / 1200.0 : 0.0;
    EXPECT_NEAR(found->rounding_sd / std::sqrt(squares - own), 1.0, 0.14) << noise;
  }
}

// With a noise of a step and more means are as good as without steps.
TEST(CoarseOutput, NoiseOfAStepLeavesNoRounding) {
  const auto found = found_in(rounded(0.013, 1.0, 50, 3).test);
  ASSERT_TRUE(found);
  EXPECT_LT(found->rounding_sd, 1e-6 * found->step);
}

// What changes by itself shows no steps: stretches that are not still are not looked at.
TEST(CoarseOutput, MovingStretchesAreNotAsked) {
  const Rounded made = rounded(0.013, 0.1, 50, 6);
  EXPECT_FALSE(coarse_output(made.test, std::vector<bool>(50, false)));
}

// Noise of numbers that were not rounded, noise far above a step, and positions without noise have no coarse steps.
TEST(CoarseOutput, NumbersWithoutCommonStepsAreNotCoarse) {
  EXPECT_FALSE(found_in(rounded(1e-12, 1e9, 20, 4).test));
  EXPECT_FALSE(found_in(rounded(1e-3, 30.0, 20, 5).test));
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    ConductedTest test;
    for (std::size_t g = 0; g < 6; ++g) {
      Stretch stretch;
      stretch.values = EvenValues(std::vector<double>(20, RandomStream(seed).normal(g)), 1.0);
      test.stretches.push_back(std::move(stretch));
    }
    EXPECT_FALSE(found_in(test)) << seed;
  }
}

}  // namespace
}  // namespace tumble
