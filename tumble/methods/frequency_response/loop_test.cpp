#include "tumble/methods/frequency_response/loop.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <functional>

#include "tumble/math/random.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

using Complex = std::complex<double>;

/// A second-order loop of 150 Hz with sd of 1e-3 in ln gain and phase.
Measured measured(std::uint64_t seed, const std::function<Complex(double)>& extra) {
  Measured m;
  const RandomStream random(seed);
  std::uint64_t draw = 0;
  for (const double f : {10.0, 20.0, 40.0, 63.0, 100.0, 125.0, 160.0, 200.0, 250.0}) {
    const double r = f / 150.0;
    const Complex h = extra(f) / Complex(1.0 - r * r, 1.2 * r);
    m.frequency.push_back(f);
    m.log_gain.push_back(std::log(std::abs(h)) + 1e-3 * random.normal(draw++));
    m.phase.push_back(std::arg(h) + 1e-3 * random.normal(draw++));
    m.log_gain_variance.push_back(1e-6);
    m.phase_variance.push_back(1e-6);
  }
  return m;
}

// 2 % at one of nine tones is 20 sd of it; the others fit without it.
TEST(PointApart, OneToneThatDepartsFromTheOthersIsFound) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto m = measured(seed, [](double f) { return f == 125.0 ? Complex(1.02) : Complex(1.0); });
    for (const LoopFit& fit : fits_of(m)) EXPECT_FALSE(fit.accepted) << seed;
    const auto apart = point_apart(m);
    ASSERT_TRUE(apart) << seed;
    EXPECT_EQ(m.frequency[apart->point], 125.0);
    EXPECT_NEAR(apart->gain, 1.02, 0.008);  // four sd of the point and of the fit
    EXPECT_NEAR(apart->phase, 0.0, 0.008);
  }
}

// A fixture that resonates at 110 Hz moves several tones: none of them is accused.
TEST(PointApart, AResonanceThatNoModelHasAccusesNoTone) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto m = measured(seed, [](double f) {
      const double r = f / 110.0;
      return 1.0 + 0.05 / Complex(1.0 - r * r, 0.2 * r);
    });
    EXPECT_FALSE(point_apart(m)) << seed;
  }
}

}  // namespace
}  // namespace tumble::frequency_response
