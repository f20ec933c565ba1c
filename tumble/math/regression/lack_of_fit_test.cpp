#include "tumble/math/regression/lack_of_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/random.hpp"

namespace tumble {
namespace {

/// A line over 6 settings, each taken three times.
struct Line {
  Matrix x{18, 2};
  std::vector<double> setting;
  std::vector<std::size_t> group;

  Line() {
    for (std::size_t i = 0; i < 18; ++i) {
      group.push_back(i / 3);
      setting.push_back(static_cast<double>(group.back()));
      x(i, 0) = 1.0;
      x(i, 1) = setting.back();
    }
  }
};

// By hand: group means against the line over 4, repeats about their means over 12 degrees of freedom.
TEST(LackOfFit, AgainstRepeatsIsTheClassicalRatio) {
  const Line line;
  std::vector<double> y;
  for (std::size_t i = 0; i < 18; ++i)
    y.push_back(line.setting[i] * line.setting[i] + std::sin(5.0 * static_cast<double>(i)));
  std::vector<double> means(6, 0.0);
  for (std::size_t i = 0; i < 18; ++i) means[i / 3] += y[i] / 3.0;
  double pure = 0.0;
  for (std::size_t i = 0; i < 18; ++i) pure += std::pow(y[i] - means[i / 3], 2);
  const QrFit fit = qr_fit(line.x, y);
  const auto found = lack_of_fit(line.x, indicators(line.group), y, identity(18));
  EXPECT_EQ(found.freedom, 4.0);
  EXPECT_EQ(found.error_freedom, 12.0);
  EXPECT_NEAR(found.ratio, (fit.residual_square - pure) / 4.0 / (pure / 12.0), 1e-6 * found.ratio);
  EXPECT_LT(found.probability, 1e-6);
}

// Tables of F: 5 % points 3.2592 for (4, 12) and 2.3719 for (4, infinity). Half of the last digit, 5e-5, times the
// density there, which is below 0.1, is 5e-6.
TEST(LackOfFit, ChancesAreThoseOfTheTables) {
  EXPECT_NEAR(chance_of_ratio(3.2592, 4.0, 12.0), 0.05, 5e-5 * 0.1);
  EXPECT_NEAR(chance_of_ratio(2.3719, 4.0, std::numeric_limits<double>::infinity()), 0.05, 5e-5 * 0.1);
  EXPECT_EQ(chance_of_ratio(0.0, 4.0, 12.0), 1.0);
}

// 2000 draws of a line that holds: below 5 % in 100 +- 9.7 of them; four standard deviations.
TEST(LackOfFit, ALineThatHoldsIsAccusedAsOftenAsStated) {
  const Line line;
  const Matrix more = indicators(line.group);
  int accused = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    std::vector<double> y(18);
    RandomStream(7).split(seed).normal(0, y);
    accused += lack_of_fit(line.x, more, y, 2.5 * identity(18)).probability < 0.05;
  }
  EXPECT_NEAR(accused, 100, 4.0 * std::sqrt(2000.0 * 0.05 * 0.95));
}

TEST(LackOfFit, OfASingleColumnGivesItsCoefficient) {
  const Line line;
  Matrix square(18, 1);
  std::vector<double> y;
  for (std::size_t i = 0; i < 18; ++i) {
    square(i, 0) = line.setting[i] * line.setting[i];
    y.push_back(3.0 - line.setting[i] + 0.25 * square(i, 0));
  }
  const auto found = lack_of_fit(line.x, square, y, 0.01 * identity(18), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(found.coefficient, 0.25, 1e-9);
  // var = 0.01/sum of squares of what the line does not explain of t^2: 3 (6 settings) 37.333 = 112
  EXPECT_NEAR(found.sd, 0.1 / std::sqrt(112.0), 1e-8);
  EXPECT_NEAR(found.ratio, std::pow(0.25 / found.sd, 2), 1e-3 * found.ratio);
  Matrix twice(18, 1);
  for (std::size_t i = 0; i < 18; ++i) twice(i, 0) = 2.0 * line.setting[i];
  EXPECT_EQ(lack_of_fit(line.x, twice, y, identity(18)).probability, 1.0);
}

}  // namespace
}  // namespace tumble
