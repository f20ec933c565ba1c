#include "tumble/math/population/new_unit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

const std::vector<UnitValue> others{{12.1, 1.0}, {14.9, 0.8}, {9.8, 1.5},  {16.4, 1.2},
                                    {13.0, 0.9}, {11.2, 2.0}, {18.3, 1.1}, {12.7, 0.7}};

TEST(UnitInPopulation, IsThatOfAnIndependentCalculation) {
  // Half of the last digit that the independent calculation printed.
  const auto far = unit_in_population(others, {20.0, 1.0});
  EXPECT_NEAR(far.value, 19.6103, 5e-5);
  EXPECT_NEAR(far.sd, 0.9961, 5e-5);
  EXPECT_NEAR(far.lower, 17.6629, 5e-5);
  EXPECT_NEAR(far.upper, 21.5672, 5e-5);
  EXPECT_NEAR(far.belongs, 0.11897, 5e-6);
  const auto near = unit_in_population(others, {14.0, 1.0});  // to the printed digits too
  EXPECT_NEAR(near.value, 13.9651, 5e-5);
  EXPECT_NEAR(near.sd, 0.9430, 5e-5);
  EXPECT_NEAR(near.lower, 12.1172, 5e-5);
  EXPECT_NEAR(near.upper, 15.8167, 5e-5);
  EXPECT_NEAR(near.belongs, 0.9222, 5e-5);
}

TEST(UnitInPopulation, NeedsFiveUnitsAndAnUncertainty) {
  const std::span all(others);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"4"}}, [&] {
    unit_in_population(all.first(4), {1.0, 1.0});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "a value and a standard uncertainty"}, [&] {
    unit_in_population(others, {1.0, 0.0});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "a value and a standard uncertainty"}, [&] {
    unit_in_population(others, {NAN, 1.0});
  }));
}

TEST(UnitInPopulationCoverage, HoldsTheTruthOfUnitsOfThePopulation) {
  // 600 fleets each: four sd are 0.036; below tau = u the interval is wider than need be.
  for (const auto& [n, sd] : {std::pair{6, 1.0}, {10, 1.0}, {20, 3.0}, {50, 1.0}}) {
    int held = 0, alien = 0;
    for (int fleet = 0; fleet < 600; ++fleet) {
      const RandomStream random = RandomStream(3).split(static_cast<std::uint64_t>(fleet));
      const auto one = [&, sd = sd](std::uint64_t k, double u, double& truth) {
        truth = sd * random.normal(2 * k);
        return UnitValue{truth + u * random.normal(2 * k + 1), u};
      };
      std::vector<UnitValue> units;
      double truth = 0.0;
      for (int i = 0; i < n; ++i) {
        const auto k = static_cast<std::uint64_t>(i);
        units.push_back(one(k, 0.5 * std::pow(4.0, random.split("u").uniform(k)), truth));
      }
      const auto found = unit_in_population(units, one(static_cast<std::uint64_t>(n), 1.0, truth));
      held += found.lower <= truth && truth <= found.upper;
      alien += found.belongs < 0.01;
    }
    EXPECT_GT(held / 600.0, 0.95 - 0.036) << n << " units, sd " << sd;
    EXPECT_LT(held / 600.0, 0.985 + 0.01) << n << " units, sd " << sd;
    EXPECT_LE(alien / 600.0, 0.025) << n << " units, sd " << sd;
  }
}

}  // namespace
}  // namespace tumble
