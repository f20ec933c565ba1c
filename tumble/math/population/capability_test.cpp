#include "tumble/math/population/capability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// Units of sd 1 around 0 of true values, each measured with u.
std::vector<UnitValue> production(std::size_t count, double u, const RandomStream& random) {
  std::vector<UnitValue> units;
  for (std::size_t i = 0; i < count; ++i)
    units.push_back({random.split("true").normal(i) + u * random.split("measured").normal(i), u});
  return units;
}

TEST(Capability, IsTheRoomToTheNearerLimit) {
  EXPECT_NEAR(capability_index({1.0, 0.5}, {-5.0, 4.0}), 2.0, 1e-15);
  EXPECT_NEAR(capability_index({1.0, 0.5}, {-unlimited, 4.0}), 2.0, 1e-15);
  EXPECT_NEAR(capability_index({1.0, 0.5}, {-0.5, unlimited}), 1.0, 1e-15);
  EXPECT_LT(capability_index({5.0, 0.5}, {-5.0, 4.0}), 0.0);
  EXPECT_EQ(capability_index({1.0, 0.0}, {-5.0, 4.0}), unlimited);
  EXPECT_EQ(capability_index({5.0, 0.0}, {-5.0, 4.0}), -unlimited);
}

TEST(Capability, ChargesTheProductionWithItsOwnSpreadOnly) {
  const auto found = capability_of(production(4000, 1.0, RandomStream(3)), {-4.0, 4.0});
  // What the measurement adds is subtracted: the variance that remains, 1 of 2, is known to 2 sqrt(2/4000), its root to
  // 2.2 %, which is 0.030 of the index; 0.1 is a little more than three of these.
  EXPECT_NEAR(found.index, 4.0 / 3.0, 0.1);
  // The sd of 4000 values is known to 1/sqrt(8000), their mean to 1/sqrt(4000) of it, in a room of 4/sqrt(2): together
  // 1.2 % of the index; four of these.
  const double room = 4.0 / std::sqrt(2.0), expected = room / 3.0;
  EXPECT_NEAR(found.measured, expected,
              4.0 * expected * std::hypot(1.0 / std::sqrt(8000.0), 1.0 / std::sqrt(4000.0) / room));
  EXPECT_LT(found.lower, found.index);
  EXPECT_GT(found.upper, found.index);
}

TEST(Capability, AnErrorThatAllUnitsShareWidensTheInterval) {
  // The mean is known to 0.5: the room to either limit is 4 -+ 1.96 x 0.5 in 95 %.
  const auto units = production(4000, 1e-3, RandomStream(3));
  const auto alone = capability_of(units, {-4.0, 4.0}), shared = capability_of(units, {-4.0, 4.0}, 0.5);
  EXPECT_EQ(alone.index, shared.index);
  EXPECT_LT(shared.lower, alone.lower);
  EXPECT_NEAR(shared.lower, (4.0 - 0.98) / 3.0, 0.05);  // 2000 draws, and the spread of 4000 units to 1.1 %
  EXPECT_NEAR(shared.upper, (4.0 + 0.98) / 3.0, 0.05);
}

TEST(Capability, OfUnitsWithoutSpreadIsOnlyKnownFromBelow) {
  const auto found = capability_of(production(20, 30.0, RandomStream(4)), {-100.0, 100.0});
  EXPECT_EQ(found.upper, unlimited);
  EXPECT_TRUE(std::isfinite(found.lower));
}

TEST(Capability, DoesNotDependOnTheUnitOfMeasure) {
  auto units = production(30, 0.5, RandomStream(5));
  const auto a = capability_of(units, {-3.0, 4.0});
  for (auto& unit : units) unit = {1e-6 * unit.value + 2e-6, 1e-6 * unit.sd};
  const auto b = capability_of(units, {-1e-6, 6e-6});
  for (const auto member : {&Capability::index, &Capability::lower, &Capability::upper, &Capability::measured})
    EXPECT_NEAR(b.*member, a.*member, 1e-6 * a.*member);
}

TEST(Capability, DrawsOfThePopulationHaveItsIntervals) {
  const auto units = production(25, 0.7, RandomStream(6));
  const auto spread = spread_of_units(units);
  const auto draws = possible_populations(units);
  ASSERT_EQ(draws.size(), 2000u);
  // In the middle of 2000 equal parts of the probability: the limits at 2.5 % are between two draws.
  EXPECT_LE(draws[49].sd, spread.sd_lower);
  EXPECT_LE(spread.sd_lower, draws[50].sd);
  EXPECT_LE(draws[1949].sd, spread.sd_upper);
  EXPECT_LE(spread.sd_upper, draws[1950].sd);
  for (std::size_t i = 1; i < draws.size(); ++i) EXPECT_LE(draws[i - 1].sd, draws[i].sd);
}

TEST(Capability, RefusesLimitsThatAreNone) {
  const auto units = production(5, 0.1, RandomStream(7));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"-inf", "inf"}}, [&] { capability_of(units, {}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"1", "-1"}}, [&] {
    capability_of(units, {1.0, -1.0});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"nan", "1"}}, [&] {
    capability_of(units, {NAN, 1.0});
  }));
}

TEST(CapabilityCoverage, IntervalsHoldTheTrueIndex) {
  constexpr int fleets = 100;
  for (const double u : {0.3, 1.0, 2.0}) {
    int held = 0;
    for (std::uint64_t i = 0; i < fleets; ++i) {
      const auto found = capability_of(production(20, u, RandomStream(8).split(i)), {-4.0, 4.0});
      held += found.lower <= 4.0 / 3.0 && 4.0 / 3.0 <= found.upper;
    }
    EXPECT_GE(held, 86) << u;  // 0.95 of 100 less four sd
  }
}

TEST(CapabilityCoverage, ASharedErrorLeavesTheIndexOfAMeanInTheMiddleInside) {
  constexpr int fleets = 200;
  for (const double shared : {0.5, 2.0}) {
    int held = 0;
    for (std::uint64_t i = 0; i < fleets; ++i) {
      const auto random = RandomStream(9).split(i);
      auto units = production(20, 0.3, random);
      const double error = shared * random.split("rig").normal(0);
      for (auto& unit : units) unit.value += error;
      const auto found = capability_of(units, {-4.0, 4.0}, shared);
      held += found.lower <= 4.0 / 3.0 && 4.0 / 3.0 <= found.upper;
    }
    EXPECT_GE(held, 178) << shared;  // 0.95 of 200 less four sd
    EXPECT_LE(held, 199) << shared;
  }
}

}  // namespace
}  // namespace tumble
