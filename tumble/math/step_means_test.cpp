#include "tumble/math/step_means.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace tumble {
namespace {

/// The means over the steps of one signal, by its own course.
void find_means(const std::vector<double>& middles, std::size_t before, std::vector<double>& means) {
  std::vector<std::array<double, 6>> signals;
  for (const double v : middles) signals.push_back({v});
  means_from_middles(middles, courses_of(signals), before, means);
}

// sin over a step of x = w h: the mean is sinc(x/2) times the value in the middle. sinc - (1 + d2/24 - 17 d4/5760) with
// d2 = 2 cos x - 2 and d4 = d2^2 begins with 367 x^6/967680.
TEST(StepMeans, AreThoseOfTheIntegralToTheSixthOrder) {
  for (const double x : {0.05, 0.157, 0.5}) {
    std::vector<double> middles, means(20);
    for (int k = -4; k < 24; ++k) middles.push_back(std::sin(x * k + 0.3));
    find_means(middles, 4, means);
    for (std::size_t k = 0; k < means.size(); ++k) {
      const double exact = std::sin(x * static_cast<double>(k) + 0.3) * std::sin(0.5 * x) / (0.5 * x);
      EXPECT_NEAR(means[k], exact, std::pow(x, 6) / 2600.0 + 1e-15) << x << " " << k;
    }
  }
}

// A drive that accelerates, keeps its rate and stops, with its kinks between steps: the middles are the means already.
// A sine that ends where it is steepest keeps its own course up to the end, but for d4 and the extrapolated d2: x^4/20.
TEST(StepMeans, KinksAreNotSmoothedOver) {
  std::vector<double> drive, sine, means(40);
  for (int k = 0; k < 40; ++k) {
    const double t = k + 0.5;
    drive.push_back(t < 10.0 ? t : t < 30.0 ? 10.0 : 40.0 - t);
    sine.push_back(t < 20.0 ? std::sin(0.157 * t) : 0.0);
  }
  find_means(drive, 0, means);
  for (std::size_t k = 0; k < 40; ++k) EXPECT_NEAR(means[k], drive[k], 1e-14) << k;
  find_means(sine, 0, means);
  for (std::size_t k = 2; k < 20; ++k)
    EXPECT_NEAR(means[k], sine[k] * std::sin(0.0785) / 0.0785, std::pow(0.157, 4) / 20.0) << k;
}

// From rest to rest by a raised cosine: the sum of the middles is the integral, and so is that of the means.
TEST(StepMeans, AMoveFromRestToRestKeepsItsSum) {
  std::vector<double> rate, means(100);
  for (int k = 0; k < 100; ++k)
    rate.push_back(k < 20 || k >= 80 ? 0.0 : 1.0 - std::cos(2.0 * std::numbers::pi * (k - 19.5) / 60.0));
  find_means(rate, 0, means);
  double sum = 0.0, of_middles = 0.0;
  for (std::size_t k = 0; k < 100; ++k) sum += means[k], of_middles += rate[k];
  EXPECT_NEAR(sum, of_middles, 1e-12);
}

TEST(StepMeans, OfFewValuesAreTheValues) {
  std::vector<double> one(1);
  find_means({5.0}, 0, one);
  EXPECT_EQ(one[0], 5.0);
}

}  // namespace
}  // namespace tumble
