#include "tumble/math/regression/smoothing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tumble {
namespace {

struct Parabola {
  std::vector<double> time, signal;
};

Parabola parabola(std::size_t n, double jitter) {
  Parabola p;
  for (std::size_t k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) + jitter * std::sin(static_cast<double>(7 * k));
    p.time.push_back(t);
    p.signal.push_back(290.0 + 0.02 * t - 3e-5 * t * t);
  }
  return p;
}

void expect_exact(const Parabola& p, const Smoothed& s) {
  for (std::size_t k = 0; k < p.time.size(); ++k) {
    // Rounding of values near 290 (5e-14) spread over the window.
    EXPECT_NEAR(s.value[k], 290.0 + 0.02 * p.time[k] - 3e-5 * p.time[k] * p.time[k], 2e-12) << k;
    EXPECT_NEAR(s.slope[k], 0.02 - 6e-5 * p.time[k], 2e-12) << k;
    EXPECT_NEAR(s.curvature[k], -6e-5, 2e-12) << k;
  }
}

TEST(LocalQuadratic, ReproducesAParabolaToTheEnds) {
  const auto p = parabola(300, 0.0);
  expect_exact(p, local_quadratic(p.time, p.signal, 30.0));
}

TEST(LocalQuadratic, DoesNotNeedEvenStamps) {
  const auto p = parabola(300, 0.2);
  expect_exact(p, local_quadratic(p.time, p.signal, 30.0));
}

TEST(LocalQuadratic, BridgesMissingSamples) {
  auto p = parabola(300, 0.0);
  for (std::size_t k = 100; k < 110; ++k) p.signal[k] = std::numeric_limits<double>::quiet_NaN();
  expect_exact(p, local_quadratic(p.time, p.signal, 30.0));
}

TEST(LocalQuadratic, EvenAndGeneralPathAgree) {
  auto p = parabola(200, 0.0);
  for (std::size_t k = 0; k < 200; ++k) p.signal[k] += std::sin(static_cast<double>(k) / 9.0);
  const auto fast = local_quadratic(p.time, p.signal, 20.0);
  auto late = p;
  late.time.back() += 1e-3;  // no longer even: every window takes the general path
  const auto slow = local_quadratic(late.time, late.signal, 20.0);
  for (std::size_t k = 0; k < 170; ++k) EXPECT_NEAR(fast.slope[k], slow.slope[k], 1e-12) << k;
}

// Windows of 4000 samples, from sums over all samples before: the parabola of each is exact, with gaps and jitter, and
// far from the zero of time and value.
TEST(LocalQuadratic, LongWindowsAreExactToo) {
  auto p = parabola(6000, 0.2);
  for (std::size_t k = 1000; k < 1500; ++k) p.signal[k] = std::numeric_limits<double>::quiet_NaN();
  const auto smoothed = local_quadratic(p.time, p.signal, 2000.0);
  for (std::size_t k = 0; k < p.time.size(); ++k) {
    // the values reach 670: rounding of 1e-13, times the 3 half widths that the sums may be away from the window
    EXPECT_NEAR(smoothed.value[k], 290.0 + 0.02 * p.time[k] - 3e-5 * p.time[k] * p.time[k], 1e-10) << k;
    EXPECT_NEAR(smoothed.slope[k], 0.02 - 6e-5 * p.time[k], 1e-12) << k;
    EXPECT_NEAR(smoothed.curvature[k], -6e-5, 1e-14) << k;
  }
}

TEST(LocalQuadratic, LongWindowsTakeTimeInProportionToTheSamples) {
  const auto p = parabola(400'000, 0.0);  // 400 000 times 400 000 samples would take minutes
  EXPECT_NEAR(local_quadratic(p.time, p.signal, 1e6).curvature[7], -6e-5, 1e-12);
}

TEST(LocalQuadratic, HasNoAnswerForFewerThanThreeSamples) {
  const std::vector<double> time{0, 1}, signal{5, 6};
  EXPECT_TRUE(std::isnan(local_quadratic(time, signal, 10.0).slope[0]));
}

}  // namespace
}  // namespace tumble
