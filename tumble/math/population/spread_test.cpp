#include "tumble/math/population/spread.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

std::vector<UnitValue> eight_units() {
  return {{12.1, 1.0}, {14.9, 0.8}, {9.8, 1.5}, {16.4, 1.2}, {13.0, 0.9}, {11.2, 2.0}, {18.3, 1.1}, {12.7, 0.7}};
}

TEST(UnitSpread, OfEightUnitsIsThatOfAnIndependentCalculation) {
  const auto units = eight_units();
  const auto spread = spread_of_units(units);
  EXPECT_NEAR(spread.sd * spread.sd, 5.950149, 1e-6);
  EXPECT_NEAR(spread.mean, 13.676281, 1e-6);
  EXPECT_NEAR(spread.scatter, 38.269529, 1e-6);
  EXPECT_NEAR(spread.sd_lower * spread.sd_lower, 1.844286, 1e-6);
  EXPECT_NEAR(spread.sd_upper * spread.sd_upper, 30.945446, 1e-6);
  EXPECT_NEAR(spread.mean_lower, 11.379672, 1e-6);
  EXPECT_NEAR(spread.mean_upper, 15.972889, 1e-6);
  EXPECT_NEAR(mean_at_spread(units, 5.950149).q, 7.238658, 1e-6);
}

TEST(UnitSpread, FollowsUnitOfMeasureAndZero) {
  auto scaled = eight_units();
  for (auto& unit : scaled) unit = {-1e-6 * unit.value + 3.0, 1e-6 * unit.sd};
  const auto a = spread_of_units(eight_units()), b = spread_of_units(scaled);
  EXPECT_NEAR(b.sd, 1e-6 * a.sd, 1e-13);
  EXPECT_NEAR(b.mean, 3.0 - 1e-6 * a.mean, 1e-13);
  EXPECT_NEAR(b.sd_upper, 1e-6 * a.sd_upper, 1e-13);
}

TEST(UnitSpread, OfEqualUnitsIsZeroWithAnUpperLimit) {
  const std::vector<UnitValue> units{{1.0, 0.5}, {1.1, 0.5}, {0.9, 0.5}, {1.0, 0.5}, {1.05, 0.5}};
  const auto spread = spread_of_units(units);
  EXPECT_EQ(spread.sd, 0.0);
  EXPECT_EQ(spread.sd_lower, 0.0);
  // The likelihood falls by 1.92 where 2 ln(1 + t/0.25) + ... does: for values without scatter t = 0.25 (e^0.96 - 1).
  EXPECT_GT(spread.sd_upper, 0.5 * std::sqrt(std::exp(0.5 * 3.84 / 2.0) - 1.0))
      << "no test shows a spread of exactly 0";
  EXPECT_LT(spread.sd_upper, 0.5 * std::sqrt(std::exp(3.84 / 2.0) - 1.0));
  EXPECT_TRUE(spread.below_stated);
}

TEST(UnitSpread, RefusesWhatIsNoPopulation) {
  const auto problems = [](std::vector<UnitValue> units) {
    try {
      spread_of_units(units);
    } catch (const Error& error) {
      return error.problems.size();
    }
    return std::size_t{0};
  };
  EXPECT_EQ(problems({{1.0, 0.1}, {2.0, 0.1}}), 1u);
  EXPECT_EQ(problems({{1.0, 0.1}, {NAN, 0.1}, {2.0, -1.0}}), 2u);
  EXPECT_EQ(problems({{1.0, 0.0}, {1.5, 0.0}, {2.0, 1.0}}), 1u);
}

/// How often the 95 % intervals hold mean 0 and spread `sd` over 400 fleets of n units, uncertainties 0.5 to 2.
std::pair<double, double> held(int n, double sd) {
  const int fleets = 400;
  int mean = 0, spread = 0;
  for (int fleet = 0; fleet < fleets; ++fleet) {
    const RandomStream random = RandomStream(7).split(static_cast<std::uint64_t>(fleet));
    std::vector<UnitValue> units;
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::uint64_t>(3 * i);
      const double u = 0.5 * std::pow(4.0, random.split("u").uniform(k));
      units.push_back({sd * random.normal(k) + u * random.normal(k + 1), u});
    }
    const auto found = spread_of_units(units);
    mean += found.mean_lower <= 0.0 && found.mean_upper >= 0.0;
    spread += found.sd_lower <= sd && found.sd_upper >= sd;
  }
  return {mean / 400.0, spread / 400.0};
}

TEST(UnitSpreadCoverage, IntervalsHoldMeanAndSpread) {
  // four sd of 400 fleets: 0.044
  for (const auto& [n, sd] : {std::pair{5, 1.0}, {10, 0.5}, {10, 3.0}, {20, 1.0}, {50, 3.0}}) {
    const auto [mean, spread] = held(n, sd);
    EXPECT_NEAR(spread, 0.95, 0.044) << n << " units, sd " << sd;
    EXPECT_GT(mean, 0.906) << n << " units, sd " << sd;
  }
}

}  // namespace
}  // namespace tumble
