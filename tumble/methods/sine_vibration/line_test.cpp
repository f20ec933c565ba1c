#include "tumble/methods/sine_vibration/line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/math/regression/sine_fit.hpp"
#include "tumble/methods/sine_vibration/measure.hpp"
#include "tumble/methods/testing/answer.hpp"

namespace tumble {
namespace {

constexpr double pi = std::numbers::pi, window = 5e-3;

/// Means of A cos(2 pi f t + p) over windows of 5 ms, exact.
struct Windows {
  std::vector<double> time, value;
};

Windows windows(double amplitude, double frequency, double phase, std::size_t count, double mean = 0.0) {
  Windows w;
  for (std::size_t j = 0; j < count; ++j) {
    w.time.push_back((static_cast<double>(j) + 0.5) * window);
    w.value.push_back(mean + amplitude * vibration::sinc(frequency * window) *
                                 std::cos(2.0 * pi * std::fmod(frequency * w.time.back(), 1.0) + phase));
  }
  return w;
}

double sd_of(const std::vector<double>& values) {
  double mean = 0.0, squares = 0.0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

// The numbers that the theory prints; tolerance: one unit of the last digit printed.
TEST(SineLine, WindowTakesItsSinc) {
  const double printed[] = {0.9959, 0.9836, 0.9634, 0.9355, 0.9003, 0.8584, 0.8103,
                            0.7568, 0.6986, 0.6366, 0.5716, 0.5046, 0.4363};
  for (int k = 0; k < 13; ++k) EXPECT_NEAR(vibration::sinc(10.0 * (k + 1) * window), printed[k], 1e-4) << k;
}

TEST(SineLine, SpreadThatTheWindowAloneGives) {
  // One unit of the last digit printed.
  EXPECT_NEAR(sine_vibration::sd_from_window(3.0, 10.0, window, 0.0), 2.113, 1e-3);
  EXPECT_NEAR(sine_vibration::sd_from_window(3.0, 80.0, window, 0.0), 1.606, 1e-3);
  EXPECT_NEAR(sine_vibration::sd_from_window(3.0, 100.0, window, 0.0), 1.350, 1e-3);
  EXPECT_NEAR(sine_vibration::sd_from_window(3.0, 130.0, window, 0.0), 0.926, 1e-3);
  EXPECT_DOUBLE_EQ(sine_vibration::sd_from_window(0.0, 10.0, window, 1e-4), 1e-4 / window / std::sqrt(6.0));
  EXPECT_NEAR(sd_of(windows(3.0, 80.0, 0.3, 20000).value), sine_vibration::sd_from_window(3.0, 80.0, window, 0.0),
              1e-4);
}

TEST(SineLine, AliasesOfTheCampaign) {
  EXPECT_NEAR(aliased_frequency(110.0, 200.0), 90.0, 1e-9);
  EXPECT_NEAR(aliased_frequency(120.0, 200.0), 80.0, 1e-9);
  EXPECT_NEAR(aliased_frequency(130.0, 200.0), 70.0, 1e-9);
}

// sd = A 0.6366 |cos(phase)| at exactly half of the windows a second: 0 to 1.910 g for 3 g.
TEST(SineLine, PhaseLockAtHalfOfTheRate) {
  for (const double phase : {0.0, 0.4, 1.0, pi / 2.0}) {
    // the phase in the middle of the windows: 100 Hz advances by a quarter of a turn to the first
    const auto w = windows(3.0, 100.0, phase - 2.0 * pi * 100.0 * 0.5 * window, 20000);
    EXPECT_NEAR(sd_of(w.value), 3.0 * 0.6366 * std::abs(std::cos(phase)), 1e-3);
  }
  EXPECT_NEAR(sd_of(windows(3.0, 100.0, -pi / 2.0, 20000).value), 1.910, 1e-3);
  const auto fault = sine_vibration::objection(100.0, window, window, 100.0, "");
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->code, "tone_on_half_rate");
  EXPECT_NEAR(value_of({*fault}, "tone_on_half_rate", "lower"), 99.7, 1e-9);
  EXPECT_NEAR(value_of({*fault}, "tone_on_half_rate", "upper"), 100.3, 1e-9);
  EXPECT_FALSE(sine_vibration::objection(99.7, window, window, 100.0, ""));
}

TEST(SineLine, NullsOfTheWindowAreNeverCorrected) {
  for (const double f : {190.5, 200.0, 209.5, 395.0})
    EXPECT_EQ(sine_vibration::objection(f, window, window, 100.0, "").value_or(Finding{}).code, "tone_on_null") << f;
  for (const double f : {10.0, 189.0, 211.0})
    EXPECT_FALSE(sine_vibration::objection(f, window, window, 100.0, "")) << f;
}

// 90 Hz, 100 s, 3 g: 106 micro-g at most, reached where f is off by 1/(2T) = 5 mHz, nothing where fT is whole.
TEST(SineLine, BrokenCyclesShiftThePlainMeanOnly) {
  double worst = 0.0;
  for (int k = 0; k < 16; ++k) {
    const auto w = windows(3.0, 90.005, pi * k / 8.0, 20000, 1.0);
    const auto line = sine_vibration::fit_line(w.time, w.value, window, 90.0);
    worst = std::max(worst, std::abs(line.plain_mean - 1.0));
    EXPECT_NEAR(line.mean, 1.0, 1e-8);
    EXPECT_NEAR(line.frequency, 90.005, 1e-8);
  }
  EXPECT_NEAR(worst, 106e-6, 1e-6);
  EXPECT_NEAR(3.0 / (pi * 90.0 * 100.0), 106e-6, 1e-6);
  const auto whole = windows(3.0, 90.0, 0.7, 20000, 1.0);
  EXPECT_NEAR(sine_vibration::fit_line(whole.time, whole.value, window, 90.0).plain_mean, 1.0, 1e-12);
}

// 50 Hz: the second harmonic stands at 100 Hz, half of the windows a second. Over an odd number of windows, and in
// blocks of odd length, it must not get into means: 19 mg over 125 windows would be 150 ug.
TEST(SineVibration, HarmonicAtHalfOfTheRateLeavesTheMeansAlone) {
  auto w = windows(3.0, 50.0, 0.3, 2001, 1.0);
  for (std::size_t j = 0; j < w.value.size(); ++j) w.value[j] += j % 2 == 0 ? 0.019 : -0.019;
  const auto line = sine_vibration::fit_line(w.time, w.value, window, 50.0);
  EXPECT_NEAR(line.mean, 1.0, 1e-8);
  for (const double block : line.block_mean) EXPECT_NEAR(block, 1.0, 1e-8);
}

// At a wrong frequency sinc(df T) of the amplitude is left: 1 mHz over 100 s -1.6 %, 5 mHz -36 %, 10 mHz all.
TEST(SineLine, FrequencyErrorTakesTheAmplitude) {
  const auto w = windows(3.0, 40.0, 0.3, 20000);
  const double full = 3.0 * vibration::sinc(40.0 * window);
  const auto left = [&](double df) {
    return std::abs(fit_sine(w.time, w.value, 40.0 + df, {.harmonics = 1, .polynomial = 0}).line[0]) / full;
  };
  // The image at -40 Hz is 1/(2 pi 80 100) = 2e-5 of the amplitude; the numbers above have two digits.
  EXPECT_NEAR(left(1e-3) - 1.0, -0.016, 1e-3);
  EXPECT_NEAR(left(5e-3) - 1.0, -0.36, 1e-2);
  EXPECT_NEAR(left(10e-3), 0.0, 1e-3);
  for (const double df : {1e-3, -4e-3, 5e-3})
    EXPECT_NEAR(sine_vibration::fit_line(w.time, w.value, window, 40.0 + df).amplitude, full, 1e-9);
}

TEST(SineLine, AboveHalfOfTheRateTheTrueFrequencyKeepsThePhase) {
  const double phase = 0.4;
  const auto w = windows(3.0, 130.0, phase, 20000);
  const auto at_origin = [&](const sine_vibration::Line& line, double f) {
    const double centre = 0.5 * (w.time.front() + w.time.back());
    return std::remainder(line.phase - 2.0 * pi * f * centre, 2.0 * pi);
  };
  const auto line = sine_vibration::fit_line(w.time, w.value, window, 130.0),
             alias = sine_vibration::fit_line(w.time, w.value, window, 70.0);
  EXPECT_NEAR(line.amplitude, 3.0 * vibration::sinc(0.65), 1e-9);
  EXPECT_NEAR(alias.amplitude, line.amplitude, 1e-9);
  EXPECT_NEAR(at_origin(line, 130.0), phase, 1e-6);
  EXPECT_NEAR(at_origin(alias, 70.0), pi - phase, 1e-6);
}

TEST(SineLine, FastFitAgreesWithTheGeneralOne) {
  auto w = windows(3.0, 61.3, 0.3, 8000, 1.0);
  std::vector<double> noise(8000);
  RandomStream(4).normal(0, noise);
  for (std::size_t i = 0; i < noise.size(); ++i)
    w.value[i] += 1e-3 * noise[i] + 2e-5 * w.time[i] + 0.02 * std::cos(4.0 * pi * 61.3 * w.time[i]);
  for (std::size_t i = 3000; i < 3100; ++i) w.value[i] = std::nan("");
  const auto fast = sine_vibration::fit_line(w.time, w.value, window, 61.301);
  const auto slow =
      fit_sine(w.time, w.value, 61.301, {.harmonics = 3, .polynomial = 1, .fit_frequency = true, .rate = 200.0});
  EXPECT_NEAR(fast.frequency, slow.frequency, 0.1 * slow.frequency_sd);
  EXPECT_NEAR(fast.amplitude, std::abs(slow.line[0]), 1e-7);
  EXPECT_NEAR(fast.mean, slow.polynomial[0], 1e-7);
  EXPECT_NEAR(fast.second, 0.02, 1e-4);  // the noise leaves 1e-3 sqrt(2/7900) = 1.6e-5: six of them
  // both variances from about 40 projections of the residuals: their ratio has a sd of sqrt(2/40 + 2/40) = 0.32, less
  // as most of the projections are the same
  EXPECT_NEAR(std::pow(fast.frequency_sd / slow.frequency_sd, 2), 1.0, 0.4);
  EXPECT_NEAR(fast.log_variance / slow.log_gain_variance(), 1.0, 0.4);
}

}  // namespace
}  // namespace tumble
