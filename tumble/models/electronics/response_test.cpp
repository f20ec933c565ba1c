#include "tumble/models/electronics/response.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble::electronics {
namespace {

using Complex = std::complex<double>;

std::vector<double> through(const Response& response, std::vector<double> samples) {
  response(samples);
  return samples;
}

template <class Function>
std::vector<double> sampled(std::size_t count, double step, Function function) {
  std::vector<double> samples(count);
  for (std::size_t k = 0; k < count; ++k) samples[k] = function(step * static_cast<double>(k));
  return samples;
}

/// Gain of a response to a complex sine of angular frequency w [rad/s], after `settle` samples, from two real runs.
Complex gain_of(const std::function<Response()>& make, double w, double step, std::size_t settle) {
  const auto c = through(make(), sampled(settle + 1, step, [&](double t) { return std::cos(w * t); }));
  const auto s = through(make(), sampled(settle + 1, step, [&](double t) { return std::sin(w * t); }));
  return Complex(c.back(), s.back()) / std::polar(1.0, w * step * static_cast<double>(settle));
}

TEST(SecondOrderLoop, ConstantsRampsAndParabolasComeOutExactly) {
  for (const double zeta : {0.1, 0.7, 1.0, 1.0 + 1e-9, 3.0})
    for (const double step : {1e-4, 1e-2, 1.0}) {  // from far below to far beyond the period of the loop
      const double f = 20.0, w = 2.0 * std::numbers::pi * f, a = 3.0, b = -2.0, c = 0.7;
      const std::size_t count = 2000 + static_cast<std::size_t>(60.0 / (std::min(zeta, 1.0 / zeta) * w * step));
      const double t0 = 1000.0 * step;
      const auto u = [&](double t) { return a + b * (t - t0) + c * (t - t0) * (t - t0); };
      const auto y = through(second_order_loop(f, zeta, step), sampled(count, step, u));
      // particular solution of y'' + 2 zeta w y' + w^2 y = w^2 u
      const double t = step * static_cast<double>(count - 1) - t0;
      const double slope = b + 2.0 * c * t;
      const double expected = u(t + t0) - 2.0 * zeta / w * slope + 2.0 * c * (4.0 * zeta * zeta - 1.0) / (w * w);
      // rounding of u of this size, divided by w step twice
      const double size = std::abs(u(t + t0)) + std::abs(u(0.0)) + a;
      EXPECT_NEAR(y.back(), expected, 1e-15 * size * (100.0 + 10.0 / std::pow(w * step, 2))) << zeta << " " << step;
    }
}

TEST(SecondOrderLoop, GainAndPhaseOfASineAreThoseOfTheTransferFunction) {
  const double f = 100.0, wn = 2.0 * std::numbers::pi * f, step = 1e-4;
  for (const double zeta : {0.2, 0.7, 1.0, 2.5})
    for (const double w : {0.1 * wn, wn, 4.0 * wn}) {
      const auto got = gain_of([&] { return second_order_loop(f, zeta, step); }, w, step, 20000);
      const Complex s(0.0, w);
      const auto relative = got / (wn * wn / (s * s + 2.0 * zeta * wn * s + wn * wn));
      const double x = w * step;
      EXPECT_NEAR(std::abs(relative), 1.0, std::pow(x, 4) / 24.0 + 1e-9) << zeta << " " << w;
      EXPECT_NEAR(std::arg(relative), 0.0, std::pow(x, 3) / 12.0 + 1e-9) << zeta << " " << w;
    }
}

TEST(SecondOrderLoop, StepOvershootsByTheTextbookAmount) {
  const double zeta = 0.3, f = 10.0, step = 1e-5;
  auto input = sampled(20000, step, [](double t) { return t > 0.005 ? 1.0 : 0.0; });
  const auto y = through(second_order_loop(f, zeta, step), input);
  const double overshoot = std::exp(-std::numbers::pi * zeta / std::sqrt(1.0 - zeta * zeta));
  EXPECT_NEAR(*std::max_element(y.begin(), y.end()), 1.0 + overshoot, 1e-6);  // flat top: second order in w step, 4e-7
  EXPECT_EQ(y.front(), 0.0);
}

TEST(FirstOrderLoop, RampLagsByTheTimeConstantAndSineFollowsTheTransferFunction) {
  const double T = 0.02, step = 1e-3, w = 2.0 * std::numbers::pi * 20.0;
  const auto ramp = through(first_order_loop(T, step), sampled(2000, step, [](double t) { return 5.0 * t; }));
  EXPECT_NEAR(ramp.back(), 5.0 * (1.999 - T), 1e-12);
  const auto relative = gain_of([&] { return first_order_loop(T, step); }, w, step, 2000) * Complex(1.0, w * T);
  const double x = w * step;
  EXPECT_NEAR(std::abs(relative), 1.0, std::pow(x, 4) / 24.0 + 1e-9);
  EXPECT_NEAR(std::arg(relative), 0.0, std::pow(x, 3) / 12.0 + 1e-9);
}

TEST(Responses, LengthOfTheBlocksDoesNotMatter) {
  const auto make = [] {
    return in_series({second_order_loop(30.0, 0.6, 1e-3), first_order_loop(0.01, 1e-3), clip(-1.0, 1.5), nullptr,
                      dead_zone(-0.1, 0.1), quantiser(0.01), scaled(300.0), pulse_counter(1e-3, 0.3)});
  };
  std::vector<double> noise(1000);
  RandomStream(5).normal(0, noise);
  const auto whole = through(make(), noise);
  auto pieces = noise;
  auto response = make();
  for (std::size_t from = 0, length = 1; from < pieces.size(); from += length, length = 1 + length * 2 % 17)
    response(std::span(pieces).subspan(from, std::min(length, pieces.size() - from)));
  EXPECT_EQ(pieces, whole);
}

TEST(Responses, InSeriesOfNothingIsNull) { EXPECT_FALSE(in_series({nullptr, nullptr})); }

TEST(Limits, ClipDeadZoneAndQuantiser) {
  const std::vector<double> samples{-3.0, -0.26, -0.2, 0.0, 0.3, 0.31, 7.0};
  EXPECT_EQ(through(clip(-1.0, 2.0), samples), (std::vector<double>{-1.0, -0.26, -0.2, 0.0, 0.3, 0.31, 2.0}));
  EXPECT_EQ(through(dead_zone(-0.2, 0.3), samples), (std::vector<double>{-3.0, -0.26, 0.0, 0.0, 0.0, 0.31, 7.0}));
  EXPECT_EQ(through(quantiser(0.25), samples), (std::vector<double>{-3.0, -0.25, -0.25, 0.0, 0.25, 0.25, 7.0}));
}

TEST(Limits, AClippedSineAroundAnOffsetIsRectified) {
  // a0 + A cos clipped at +-L moves the mean by the area that is cut off: (1/pi) [ -(A sin p - c p) ] of each side with
  // cos p = c/A, c = L - a0 above and L + a0 below
  const double a0 = 1.0, A = 40.0, L = 30.0;
  const auto cut = [&](double c) { return (std::sqrt(A * A - c * c) - c * std::acos(c / A)) / std::numbers::pi; };
  const std::size_t count = 100000;
  auto samples = sampled(count, 1.0 / static_cast<double>(count),
                         [&](double t) { return a0 + A * std::cos(2.0 * std::numbers::pi * (t + 0.5e-5)); });
  samples = through(clip(-L, L), samples);
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(count);
  EXPECT_NEAR(mean, a0 - cut(L - a0) + cut(L + a0), 1e-6);  // midpoint rule with corners: A (2 pi/n)^2
  EXPECT_LT(mean, a0 - 0.1);
}

TEST(PulseCounter, TotalOfARunIsWithinOnePulse) {
  const double step = 1e-3;
  std::vector<double> rates(200000);
  RandomStream(11).normal(0, rates);
  for (double& rate : rates) rate = 400.0 * rate - 30.0;  // both signs
  const auto counts = through(pulse_counter(step, 0.37), rates);
  long double integral = 0.0L, total = 0.0L, worst = 0.0L;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    EXPECT_EQ(counts[k], std::floor(counts[k]));
    integral += static_cast<long double>(rates[k]) * static_cast<long double>(step);
    total += static_cast<long double>(counts[k]);
    worst = std::max(worst, std::abs(total - integral));
  }
  EXPECT_LE(worst, 1.0L);
  EXPECT_GT(worst, 0.5L);
}

struct Spread {
  double variance, correlation;
};

Spread spread_of(const std::vector<double>& errors) {
  const auto n = static_cast<double>(errors.size());
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / n;
  double square = 0.0, product = 0.0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    square += (errors[k] - mean) * (errors[k] - mean);
    if (k > 0) product += (errors[k] - mean) * (errors[k - 1] - mean);
  }
  return {square / n, product / square};
}

TEST(PulseCounter, ConstantInputScattersAsItsFractionSays) {  // (3.14)
  for (const double p : {0.1234, 0.4321, 0.5678, 0.9173}) {
    const auto counts = through(pulse_counter(0.005, 0.61), std::vector<double>(100000, (17.0 + p) / 0.005));
    const auto spread = spread_of(counts);
    // a sequence of two values whose share of ones is off by at most 1/n
    EXPECT_NEAR(spread.variance, p * (1.0 - p), 2e-5) << p;
    EXPECT_NEAR(spread.correlation, -std::min(p, 1.0 - p) / std::max(p, 1.0 - p), 2e-4) << p;
  }
}

TEST(PulseCounter, OverAllFractionsTheErrorHasOneSixthAndMinusOneHalf) {  // (3.14)
  const std::size_t n = 200000;
  std::vector<double> rates(n);
  for (std::size_t k = 0; k < n; ++k) rates[k] = (40.0 + 3.0 * RandomStream(3).uniform(k)) / 0.005;
  const auto counts = through(pulse_counter(0.005, 0.2), rates);
  std::vector<double> errors(n);
  for (std::size_t k = 0; k < n; ++k) errors[k] = counts[k] - rates[k] * 0.005;
  const auto spread = spread_of(errors);
  // differences of uniform fractions: fourth moment 1/15, so sd of the variance below sqrt((1/15 - 1/36) 2/n)
  EXPECT_NEAR(spread.variance, 1.0 / 6.0, 4.0 * std::sqrt(0.078 / static_cast<double>(n)));
  EXPECT_NEAR(spread.correlation, -0.5, 4.0 / std::sqrt(static_cast<double>(n)));
}

TEST(Responses, RefuseWhatMakesNoSense) {
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "natural_frequency of a loop"},
                      [&] { second_order_loop(0.0, 0.7, 0.01); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "damping_ratio of a loop"},
                      [&] { second_order_loop(10.0, 0.0, 0.01); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.pattern = "step of a loop"}, [&] { second_order_loop(10.0, 0.7, 0.0); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "time_constant of a loop"},
                      [&] { first_order_loop(-1.0, 0.01); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "lower limit of the range"}, [&] { clip(1.0, 1.0); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.pattern = "a dead zone must contain zero"}, [&] { dead_zone(0.1, 0.2); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.pattern = "resolution must be positive"}, [&] { quantiser(0.0); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.pattern = "step of a pulse counter"}, [&] { pulse_counter(0.0, 0.5); }));
}

}  // namespace
}  // namespace tumble::electronics
