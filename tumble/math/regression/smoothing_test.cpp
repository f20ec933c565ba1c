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

TEST(LocalQuadratic, reproduces_a_parabola_to_the_ends) {
  const auto p = parabola(300, 0.0);
  expect_exact(p, local_quadratic(p.time, p.signal, 30.0));
}

TEST(LocalQuadratic, does_not_need_even_stamps) {
  const auto p = parabola(300, 0.2);
  expect_exact(p, local_quadratic(p.time, p.signal, 30.0));
}

TEST(LocalQuadratic, bridges_missing_samples) {
  auto p = parabola(300, 0.0);
  for (std::size_t k = 100; k < 110; ++k) p.signal[k] = std::numeric_limits<double>::quiet_NaN();
  expect_exact(p, local_quadratic(p.time, p.signal, 30.0));
}

TEST(LocalQuadratic, even_and_general_path_agree) {
  auto p = parabola(200, 0.0);
  for (std::size_t k = 0; k < 200; ++k) p.signal[k] += std::sin(static_cast<double>(k) / 9.0);
  const auto fast = local_quadratic(p.time, p.signal, 20.0);
  auto late = p;
  late.time.back() += 1e-3;  // no longer even: every window takes the general path
  const auto slow = local_quadratic(late.time, late.signal, 20.0);
  for (std::size_t k = 0; k < 170; ++k) EXPECT_NEAR(fast.slope[k], slow.slope[k], 1e-12) << k;
}

TEST(LocalQuadratic, has_no_answer_for_fewer_than_three_samples) {
  const std::vector<double> time{0, 1}, signal{5, 6};
  EXPECT_TRUE(std::isnan(local_quadratic(time, signal, 10.0).slope[0]));
}

}  // namespace
}  // namespace tumble
