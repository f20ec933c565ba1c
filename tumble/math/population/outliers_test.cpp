#include "tumble/math/population/outliers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// n units of spread 1 and uncertainties 0.3 to 1; the first `aliens` are 6 to one side or the other.
std::vector<UnitValue> fleet(int n, int aliens, std::uint64_t seed) {
  const RandomStream random(seed);
  std::vector<UnitValue> units;
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::uint64_t>(i);
    const double u = 0.3 + 0.7 * random.split("u").uniform(k);
    const double truth = i < aliens ? (i % 2 ? 6.0 : -6.0) : random.normal(2 * k);
    units.push_back({truth + u * random.normal(2 * k + 1), u});
  }
  return units;
}

TEST(OutlierUnits, AreFoundAmongManyAndTheSpreadIsThatOfTheOthers) {
  int found = 0, wrong = 0;
  double variance = 0.0, of_all = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto units = fleet(100, 10, seed);
    const auto result = outlier_units(units);
    of_all += spread_of_units(units).sd * spread_of_units(units).sd / 20.0;
    found += static_cast<int>(std::count(result.outlier.begin(), result.outlier.begin() + 10, true));
    wrong += static_cast<int>(std::count(result.outlier.begin() + 10, result.outlier.end(), true));
    variance += result.kept.sd * result.kept.sd / 20.0;
  }
  EXPECT_GT(found, 160);     // of 200
  EXPECT_LT(wrong, 8);       // of 1800; a share of 0.01 of the found is 2
  EXPECT_GT(of_all, 4.0);    // 1 + 0.1 36 less sampling
  EXPECT_LT(variance, 1.5);  // the few that are not found add to it
}

TEST(OutlierUnits, AreRareInASoundFleet) {
  int any = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const auto result = outlier_units(fleet(50, 0, 1000 + seed));
    any += std::ranges::count(result.outlier, true) > 0;
  }
  EXPECT_LE(any, 12) << "1 % of 300 are 3, four sd more are 10";
}

TEST(BatchChange, FindsPlaceAndStep) {
  int held = 0, found = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    auto units = fleet(60, 0, 300 + seed);
    for (std::size_t i = 24; i < units.size(); ++i) units[i].value += 2.0;
    const auto change = batch_change(units, 1.0, seed);
    held += change.earliest <= 24 && change.latest >= 24;
    found += change.p < 0.05;
  }
  EXPECT_GE(held, 55);  // 0.97 of 60 less four sd
  EXPECT_GE(found, 55);
}

TEST(BatchChange, IsRareWithoutAChange) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) found += batch_change(fleet(30, 0, 700 + seed), 1.0, seed).p < 0.05;
  EXPECT_LE(found, 23) << "5 % of 200 are 10, four sd more are 22";
}

TEST(BatchChange, NeedsSixUnits) {
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"5"}, .pattern = "change"},
                      [&] { batch_change(fleet(5, 0, 1), 1.0); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"4"}, .pattern = "outliers"},
                      [&] { outlier_units(fleet(4, 0, 1)); }));
}

TEST(OutlierUnits, TheMiddleOfFewUnitsIsNoPopulation) {
  // drawn from one normal law; six lie close together by chance
  const std::vector<double> values{-0.849, 3.906, 4.458, -1.401, -1.664, -0.697, -1.020, -0.860, -7.631};
  std::vector<UnitValue> units;
  for (const double value : values) units.push_back({value, 0.1});
  const auto found = outlier_units(units);
  EXPECT_EQ(std::ranges::count(found.outlier, true), 0);
  EXPECT_NEAR(found.kept.sd, 3.49, 0.1);
  units[1].value = units[2].value = -1.0;
  EXPECT_EQ(std::ranges::count(outlier_units(units).outlier, true), 1) << "one of nine";
}

}  // namespace
}  // namespace tumble
