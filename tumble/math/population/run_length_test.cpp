#include "tumble/math/population/run_length.hpp"

#include <gtest/gtest.h>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

// Constants of an independent solution of the integral equations (numpy), to one unit of the last digit that it printed.
TEST(RunLength, LimitsOfChartsAreThoseOfAnIndependentSolution) {
  EXPECT_NEAR(limit_of_ewma(0.05, 370.4), 2.4901, 1e-4);
  EXPECT_NEAR(limit_of_ewma(0.1, 370.4), 2.7015, 1e-4);
  EXPECT_NEAR(limit_of_ewma(0.2, 370.4), 2.8593, 1e-4);
  EXPECT_NEAR(limit_of_ewma(0.4, 500.0), 3.0540, 1e-4);
  EXPECT_NEAR(limit_of_cusum(0.25, 370.4), 8.0103, 1e-4);
  EXPECT_NEAR(limit_of_cusum(0.5, 370.4), 4.7749, 1e-4);
  EXPECT_NEAR(limit_of_cusum(1.0, 500.0), 2.6651, 1e-4);
}

TEST(RunLength, ShiftsAreFoundSooner) {
  // Half of the last digit printed by the same solution.
  EXPECT_NEAR(run_length_of_ewma(0.2, 2.8593, 0.5), 36.2, 0.05);
  EXPECT_NEAR(run_length_of_ewma(0.2, 2.8593, 1.0), 9.8, 0.05);
  EXPECT_NEAR(run_length_of_ewma(0.2, 2.8593, 2.0), 3.59, 0.005);
  EXPECT_NEAR(run_length_of_cusum(0.5, 4.7749, 0.5), 35.3, 0.05);
  EXPECT_NEAR(run_length_of_cusum(0.5, 4.7749, 1.0), 9.9, 0.05);
  EXPECT_NEAR(run_length_of_cusum(0.5, 4.7749, 2.0), 3.86, 0.005);
  EXPECT_NEAR(run_length_of_ewma(0.2, 3.0), 559.9, 0.5);
  EXPECT_NEAR(run_length_of_cusum(0.5, 5.0), 465.4, 0.1);
}

// 1/erfc(3/sqrt(2)) is 370.398; half of the digit that is written here.
TEST(RunLength, OfEachPointAloneIsThatOfTheNormalLaw) { EXPECT_NEAR(run_length_of_ewma(1.0, 3.0), 370.4, 0.05); }

TEST(RunLength, RefusesImpossibleCharts) {
  EXPECT_TRUE(
      refuses(Error::Kind::bad_input, Asked{.values = {"0"}, .pattern = "lambda"}, [&] { limit_of_ewma(0.0, 370.0); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"1"}, .pattern = "run length"},
                      [&] { limit_of_ewma(0.2, 1.0); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"-1"}, .pattern = "k of"},
                      [&] { limit_of_cusum(-1.0, 370.0); }));
}

}  // namespace
}  // namespace tumble
