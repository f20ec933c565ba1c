#include "tumble/math/bisection.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

TEST(Bisection, KeepsThePlaceAndHalvesTheInterval) {
  const Bisected third = bisected(0.0, 1.0, 20, [](double x) { return x < 1.0 / 3.0; });
  EXPECT_LT(third.low, 1.0 / 3.0);
  EXPECT_GE(third.high, 1.0 / 3.0);
  EXPECT_EQ(third.high - third.low, 0x1p-20);  // exact: powers of two
  EXPECT_EQ(third.middle(), third.low + 0x1p-21);
}

TEST(Bisection, EndsAtTheEndsWhereTheAnswerNeverChanges) {
  EXPECT_EQ(bisected(2.0, 4.0, 3, [](double) { return true; }).high, 4.0);
  EXPECT_EQ(bisected(2.0, 4.0, 3, [](double) { return false; }).low, 2.0);
  EXPECT_EQ(bisected(2.0, 4.0, 0, [](double) { return true; }).low, 2.0);
}

}  // namespace
}  // namespace tumble
