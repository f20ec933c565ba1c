#include "tumble/report/rounding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tumble/report/report.hpp"

namespace tumble {
namespace {

TEST(WithUncertainty, TwoDigitsOfSdDecide) {
  EXPECT_EQ(with_uncertainty(6.66, 0.011), "6.660 ± 0.011");
  EXPECT_EQ(with_uncertainty(-132.7, 23.456), "-133 ± 23");
  EXPECT_EQ(with_uncertainty(0.0052, 0.0011), "0.0052 ± 0.0011");
  EXPECT_EQ(with_uncertainty(123.456789, 0.0000012), "123.4567890 ± 0.0000012");
  EXPECT_EQ(with_uncertainty(123456.0, 1234.0), "123500 ± 1200");
}

TEST(WithUncertainty, SdThatRoundsUpToTheNextPowerOfTen) {
  EXPECT_EQ(with_uncertainty(1234.0, 99.6), "1230 ± 100");
  EXPECT_EQ(with_uncertainty(1.0, 0.0996), "1.00 ± 0.10");
  EXPECT_EQ(with_uncertainty(9.99996, 0.00099), "9.99996 ± 0.00099");
}

TEST(WithUncertainty, VeryLargeAndVerySmall) {
  EXPECT_EQ(with_uncertainty(6.66e-5, 1.1e-7), "(6.660 ± 0.011)e-5");
  EXPECT_EQ(with_uncertainty(-6.66e12, 1.1e10), "(-6.660 ± 0.011)e12");
  EXPECT_EQ(with_uncertainty(1.5e-300, 2.0e-302), "(1.500 ± 0.020)e-300");
  EXPECT_EQ(with_uncertainty(1.5e308, 2.0e306), "(1.500 ± 0.020)e308");
  EXPECT_EQ(with_uncertainty(3.3e-310, 1.0e-310), "(3.3 ± 1.0)e-310");
}

TEST(WithUncertainty, ValueLostInItsUncertainty) {
  EXPECT_EQ(with_uncertainty(0.0012, 50.0), "0 ± 50");
  EXPECT_EQ(with_uncertainty(-0.0012, 50.0), "0 ± 50");
  EXPECT_EQ(with_uncertainty(0.0, 0.5), "0.00 ± 0.50");
  EXPECT_EQ(with_uncertainty(1e-9, 2e7), "(0.0 ± 2.0)e7");
}

TEST(WithUncertainty, NoSdToRoundBy) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(with_uncertainty(6.66, 0.0), "6.66 ± 0");
  EXPECT_EQ(with_uncertainty(6.66, nan), "6.66 ± unknown");
  EXPECT_EQ(with_uncertainty(6.66, -1.0), "6.66 ± unknown");
  EXPECT_EQ(with_uncertainty(6.66, inf), "6.66 ± unbounded");
  EXPECT_EQ(with_uncertainty(nan, 0.1), "unknown");
  EXPECT_EQ(with_uncertainty(inf, 0.1), "inf ± 0.1");
}

TEST(WithUncertainty, NeverShowsDigitsThatADoubleDoesNotHave) {
  EXPECT_EQ(with_uncertainty(1e6, 1e-11), "1000000 ± 1e-11");
}

TEST(LinedUp, PointsStandBelowEachOther) {
  EXPECT_EQ(lined_up({10.0, 20.5, -500.25, NAN}, " ", "."),
            (std::vector<std::string>{"10.  ", "20.5 ", "-500.25", "–.  "}));
  EXPECT_EQ(lined_up({1.0, 2.0}, " ", " "), (std::vector<std::string>{"1", "2"}));
}

TEST(Interval95, UsesTheDegreesOfFreedom) {
  // Student's t at 0.975: 1.959964 for the normal distribution, 3.182446 for 3 degrees of freedom (printed tables).
  const auto normal = interval95(1.0, 0.1, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(normal.lower, 1.0 - 0.1959964, 1e-7);
  EXPECT_NEAR(normal.upper, 1.0 + 0.1959964, 1e-7);
  EXPECT_NEAR(interval95(1.0, 0.1, 3.0).upper, 1.3182446, 1e-7);
  EXPECT_TRUE(std::isnan(interval95(1.0, 0.1, 0.0).lower));
  EXPECT_TRUE(std::isnan(interval95(1.0, NAN, 5.0).upper));
}

// A standard deviation of 2 deg/h with an interval of its own, which is not 2 -+ 1.96 sd.
TEST(Interval95, IsTheParametersOwnWhereItHasOne) {
  Estimate estimate;
  estimate.parameters.push_back({"turn_on_repeatability", "s", Unit::parse("deg/h"), si(2.0, "deg/h"), "", 3.0});
  estimate.covariance = Matrix(1, 1, si(1.0, "deg/h") * si(1.0, "deg/h"));
  EXPECT_EQ(interval_text(estimate, 0), "[-1.2, 5.2]");
  estimate.parameters[0].lower = si(1.1, "deg/h");
  estimate.parameters[0].upper = si(7.5, "deg/h");
  EXPECT_EQ(interval_text(estimate, 0), "[1.1, 7.5]");
  EXPECT_NEAR(interval95(estimate, 0).upper, si(7.5, "deg/h"), 1e-20);
}

}  // namespace
}  // namespace tumble
