#include "tumble/math/population/drift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

/// Time in years here: the unit of time is the caller's.
UnitHistory worked() {
  return {{{0.0, 0.1, 0.5}, {1.0, 0.9, 0.5}, {2.0, 0.4, 0.5}, {3.0, 1.6, 0.5}, {4.0, 2.1, 0.5}}, 0.0, 0.3};
}

TEST(Drift, ForecastIsThatOfAnIndependentCalculation) {
  const auto in_a_year = forecast(worked(), 1.0, 5.0);
  // The independent calculation was printed with four decimals: half of the last.
  EXPECT_NEAR(in_a_year.value, 2.1246, 5e-5);
  EXPECT_NEAR(in_a_year.variance, 1.3062, 5e-5);
}

TEST(Drift, IntervalIsThatOfAnIndependentCalculation) {
  for (const auto& [walk, interval] : {std::pair{0.7, 4.601}, {1.0, 3.547}, {1.4, 2.345}}) {
    const auto found = recalibration_interval(worked(), {{walk}, {1.0}}, -6.0, 6.0, 0.05, 20.0);
    EXPECT_NEAR(found.interval, interval, 1e-3) << walk;  // printed with three decimals
    EXPECT_EQ(found.shortest, found.interval);
  }
}

TEST(Drift, AUnitThatIsOutsideAlreadyHasNoInterval) {
  EXPECT_EQ(recalibration_interval(worked(), {{1.0}, {1.0}}, -1.0, 1.0, 0.05, 20.0).interval, 0.0);
  EXPECT_EQ(recalibration_interval(worked(), {{1e-3}, {1.0}}, -1e3, std::numeric_limits<double>::infinity(), 0.05, 20.0)
                .interval,
            20.0);
}

/// Histories of units whose random walk is 1 a root year and whose trends scatter by 0.3 a year.
UnitHistory history(int visits, const RandomStream& random, double& walk) {
  UnitHistory out{{}, 0.0, 0.3};
  const double offset = 0.5 * random.normal(1000), trend = 0.3 * random.normal(1001);
  walk = 0.0;
  for (int k = 0; k < visits; ++k) {
    const auto i = static_cast<std::uint64_t>(k);
    if (k > 0) walk += random.normal(2 * i);
    out.visits.push_back({static_cast<double>(k), offset + trend * k + walk + 0.5 * random.normal(2 * i + 1), 0.5});
  }
  walk += offset + trend * (visits - 1);
  return out;
}

TEST(Drift, RiskAtTheIntervalIsTheOneStated) {
  std::vector<UnitHistory> fleet;
  double truth = 0.0;
  for (std::uint64_t i = 0; i < 60; ++i) fleet.push_back(history(4, RandomStream(2).split(i), truth));
  const auto walks = walk_of_units(fleet);
  double mean = 0.0;
  for (std::size_t i = 0; i < walks.walk.size(); ++i) mean += walks.weight[i] * walks.walk[i];
  EXPECT_NEAR(mean, 1.0, 0.4) << "four times the uncertainty of 60 units";
  int outside = 0, units = 300;
  for (int i = 0; i < units; ++i) {
    const RandomStream random = RandomStream(3).split(static_cast<std::uint64_t>(i));
    const auto unit = history(3, random, truth);
    const auto found = recalibration_interval(unit, walks, -6.0, 6.0, 0.05, 20.0);
    const double trend = 0.3 * random.normal(1001);
    const double then = truth + trend * found.interval + std::sqrt(found.interval) * random.normal(2000);
    outside += std::abs(then) > 6.0;
    EXPECT_LE(found.shortest, found.interval + 0.5);
    EXPECT_GE(found.longest, found.interval - 0.5);
  }
  EXPECT_NEAR(outside / 300.0, 0.05, 0.05) << "four sd of 300 units";
}

TEST(Drift, TheTrendIsThatOfAnIndependentCalculation) {
  const auto trend = drift_rate(worked(), 1.0);
  // The independent calculation was printed with four decimals: half of the last.
  EXPECT_NEAR(trend.value, 0.1192, 5e-5);
  EXPECT_NEAR(trend.sd, 0.2608, 5e-5);
}

TEST(Drift, AnErrorThatAllVisitsShareWidensTheForecastAlone) {
  auto shared = worked();
  shared.shared = Matrix(5, 1, 2.0);
  const auto alone = forecast(worked(), 1.0, 5.0), with = forecast(shared, 1.0, 5.0);
  EXPECT_NEAR(with.value, alone.value, 1e-12);
  EXPECT_NEAR(with.variance, alone.variance + 4.0, 1e-9);
  EXPECT_NEAR(drift_rate(shared, 1.0).sd, drift_rate(worked(), 1.0).sd, 1e-9);
  shared.shared = Matrix(2, 1, 2.0);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "number of rows"}, [&] { forecast(shared, 1.0, 5.0); }));
}

TEST(Drift, RefusesWhatShowsNoDrift) {
  UnitHistory once{{{0.0, 1.0, 0.1}}, 0.0, 0.3};
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "two visits at different times"},
                      [&] { walk_of_units(std::vector{once}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"0"}, .pattern = "order of time"}, [&] {
    forecast({{{1.0, 1.0, 0.1}, {0.0, 1.0, 0.1}}, 0.0, 0.3}, 1.0, 2.0);
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"1"}, .pattern = "no uncertainty above zero"}, [&] {
    forecast({{{1.0, 1.0, 0.0}}, 0.0, 0.3}, 1.0, 2.0);
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "without a visit"}, [&] { forecast({}, 1.0, 2.0); }));
}

}  // namespace
}  // namespace tumble
