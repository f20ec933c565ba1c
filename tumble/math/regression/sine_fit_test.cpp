#include "tumble/math/regression/sine_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double turn = 2.0 * std::numbers::pi;

struct Made {
  std::vector<double> time, value;
};

/// A cos(2 pi f t + p) at `rate` from t = 3 s on.
Made wave(double f, double amplitude, double phase, double rate, std::size_t samples) {
  Made made;
  for (std::size_t i = 0; i < samples; ++i) {
    made.time.push_back(3.0 + static_cast<double>(i) / rate);
    made.value.push_back(amplitude * std::cos(turn * f * made.time.back() + phase));
  }
  return made;
}

/// The line with its phase counted from t = 0.
std::complex<double> at_zero(const SineFit& fit, double f) {
  return fit.line[0] * std::polar(1.0, -turn * f * fit.centre);
}

TEST(SineFit, FourParametersWithHarmonicsDriftAndGapToRounding) {
  Made made = wave(13.37, 2.0, 0.4, 200.0, 2000);
  for (std::size_t i = 0; i < made.time.size(); ++i) {
    made.value[i] += 1.5 + 0.1 * made.time[i] + 0.3 * std::sin(turn * 2.0 * 13.37 * made.time[i]);
    if (i > 500 && i < 700) made.value[i] = std::nan("");
  }
  const SineFit fit = fit_sine(made.time, made.value, 13.33, {.harmonics = 2, .fit_frequency = true, .rate = 200.0});
  // Rounding of 2 pi f t at 13 s is 1e-13 of a cycle, and of the sum over 1800 samples less than 1e-12.
  EXPECT_NEAR(fit.frequency, 13.37, 1e-11);
  EXPECT_NEAR(std::abs(fit.line[0]), 2.0, 1e-11);
  EXPECT_NEAR(std::arg(at_zero(fit, fit.frequency)), 0.4, 1e-9);
  EXPECT_NEAR(std::abs(fit.line[1]), 0.3, 1e-11);
  EXPECT_EQ(fit.samples, 1801u);
}

TEST(SineFit, LinesAboveHalfTheRateAtTheirTrueFrequency) {
  // 130 Hz at 200 Hz shows at 70 Hz with the phase turned round; fitted at 130 Hz it is right.
  const Made made = wave(130.0, 1.0, 0.7, 200.0, 2000);
  const SineFit fit = fit_sine(made.time, made.value, 130.0, {.rate = 200.0});
  EXPECT_NEAR(std::abs(fit.line[0]), 1.0, 1e-11);
  EXPECT_NEAR(std::arg(at_zero(fit, 130.0)), 0.7, 1e-9);
  EXPECT_DOUBLE_EQ(aliased_frequency(130.0, 200.0), 70.0);
  EXPECT_DOUBLE_EQ(aliased_frequency(210.0, 200.0), 10.0);
}

TEST(SineFit, AFrequencyErrorTakesSincOfTheAmplitude) {
  // sinc(df T): 1 mHz over 100 s is -1.6 %, 5 mHz -36 % (3.15). Half of the last digit is 5e-5; the image at -90 Hz is
  // 1/(2 pi 180 100) = 9e-6 of the amplitude at most.
  const Made made = wave(90.0, 3.0, 0.0, 500.0, 50000);
  const auto loss = [&](double df) {
    return 1.0 - std::abs(fit_sine(made.time, made.value, 90.0 + df, {.polynomial = 0}).line[0]) / 3.0;
  };
  EXPECT_NEAR(loss(1e-3), 0.0164, 1e-4);
  EXPECT_NEAR(loss(5e-3), 0.3634, 1e-4);
}

/// Mean of z^2 over many seeds, z the error in standard uncertainties: nu/(nu - 2) where the intervals hold.
TEST(SineFitCoverage, UncertaintiesHoldInWhiteAndInColouredNoise) {
  constexpr int seeds = 1500;
  for (const double memory : {0.0, 0.97}) {
    double gain = 0.0, phase = 0.0, expected = 0.0;
    for (int seed = 1; seed <= seeds; ++seed) {
      const RandomStream random(static_cast<std::uint64_t>(seed));
      Made made = wave(4.13, 30.0, 0.2, 100.0, 800);
      double noise = 0.0;
      for (std::size_t i = 0; i < 800; ++i) made.value[i] += noise = memory * noise + random.normal(i);
      const SineFit fit = fit_sine(made.time, made.value, 4.1, {.fit_frequency = true, .rate = 100.0});
      const auto ratio = fit.line[0] / (30.0 * std::polar(1.0, 0.2 + turn * 4.13 * fit.centre));
      gain += std::pow(std::log(std::abs(ratio)), 2) / fit.log_gain_variance() / seeds;
      phase += std::pow(std::arg(ratio), 2) / fit.phase_variance() / seeds;
      expected += fit.degrees_of_freedom / (fit.degrees_of_freedom - 2.0) / seeds;
    }
    // z^2 is F(1, 36): variance 2.7; 4 sigma of the mean of 1500: 0.17. The red noise falls as 1/f^2 across the band in
    // which its density is taken, which overestimates by up to 1/(1 - 0.3^2).
    EXPECT_NEAR(gain, expected, 0.17 + (memory > 0.0 ? 0.1 : 0.0)) << memory;
    EXPECT_NEAR(phase, expected, 0.17 + (memory > 0.0 ? 0.1 : 0.0)) << memory;
  }
}

TEST(SineFit, RefusesWhatCannotBeTold) {
  const Made made = wave(100.0, 1.0, 0.3, 200.0, 400);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"100", "2", "200"}},
                      [&] { fit_sine(made.time, made.value, 100.0, {.rate = 200.0}); }));  // half of the rate
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"200.1", "2", "200"}},
                      [&] { fit_sine(made.time, made.value, 200.1, {.rate = 200.0}); }));  // next to an offset
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"2", "0.2"}},
                      [&] { fit_sine(made.time, made.value, 0.2, {.rate = 200.0}); }));  // less than a cycle
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"-1"}},
                      [&] { fit_sine(made.time, made.value, -1.0, {.rate = 200.0}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "fewer than two samples"},
                      [&] { fit_sine(made.time, std::vector<double>(400, std::nan("")), 10.0, {.rate = 200.0}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "does not move"},
                      [&] { strongest_frequency(std::vector<double>(100, 2.5), 10.0); }));
}

TEST(SineFit, FindsTheStrongestLine) {
  Made made = wave(7.3, 1.0, 0.3, 200.0, 1000);
  for (std::size_t i = 0; i < 1000; ++i) made.value[i] += 50.0 + 0.2 * std::cos(turn * 41.0 * made.time[i]);
  EXPECT_NEAR(strongest_frequency(made.value, 200.0), 7.3, 0.02);  // a tenth of 1/T
}

}  // namespace
}  // namespace tumble
