#include "tumble/methods/frequency_response/extent.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::frequency_response {
namespace {

/// 4 s at 400 Hz of 20 Hz, with 25 Hz outside of [begin, end].
Samples two_tones(double begin, double end, double noise) {
  Samples s;
  s.rate = 400.0;
  const RandomStream random(1);
  for (int i = 0; i < 1600; ++i) {
    const double t = i / s.rate, f = t < begin || t > end ? 25.0 : 20.0;
    s.time.push_back(t);
    s.value.push_back(10.0 * std::cos(two_pi * f * t) + noise * random.normal(static_cast<std::uint64_t>(i)));
  }
  return s;
}

TEST(Extent, IsThatOfTheTone) {
  const Extent late = extent_of(two_tones(0.0, 3.5, 0.5), 20.0);
  EXPECT_TRUE(late.cut);
  EXPECT_GT(late.end, 3.3);
  EXPECT_LT(late.end, 3.51);
  EXPECT_EQ(late.begin, 0.0);
  const Extent early = extent_of(two_tones(0.6, 4.0, 0.5), 20.0);
  EXPECT_GT(early.begin, 0.59);
  EXPECT_LT(early.begin, 0.8);
}

TEST(Extent, IsAllOfASoundSegment) {
  for (const double noise : {0.0, 0.1, 1.0, 4.0})
    EXPECT_FALSE(extent_of(two_tones(0.0, 4.0, noise), 20.0).cut) << noise;
}

}  // namespace
}  // namespace tumble::frequency_response
