#include "tumble/units/constants.hpp"

#include <gtest/gtest.h>

#include "tumble/units/unit.hpp"

namespace tumble {
namespace {

// Unit parses the exact definitions and rounds once; a constant of another rounding would show in the last bit.
TEST(Constants, AreTheFactorsOfTheirUnitsToTheLastBit) {
  EXPECT_EQ(degree, Unit::parse("deg").factor());
  EXPECT_EQ(arcsecond, Unit::parse("arcsec").factor());
  EXPECT_EQ(minute, Unit::parse("min").factor());
  EXPECT_EQ(hour, Unit::parse("h").factor());
  EXPECT_EQ(standard_gravity, Unit::parse("g").factor());
  EXPECT_EQ(micro_g, Unit::parse("ug").factor());
}

// The digits of pi by OEIS A000796; doubling and halving are exact, so that all parts of a turn are rounded once.
TEST(Constants, PartsOfATurnAreRoundedOnce) {
  EXPECT_EQ(pi, 3.14159265358979323846264338327950288);
  EXPECT_EQ(two_pi, 6.28318530717958647692528676655900577);
  EXPECT_EQ(half_pi, 1.57079632679489661923132169163975144);
  EXPECT_EQ(degrees_per_radian, 57.2957795130823208767981548141051703);
}

}  // namespace
}  // namespace tumble
