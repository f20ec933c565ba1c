#include "tumble/math/population/control_chart.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

TEST(SelfStarting, IsThatOfAnIndependentCalculation) {
  const auto q = self_starting(std::vector<double>{5.1, 4.8, 5.6, 5.0, 6.3});
  ASSERT_EQ(q.size(), 5u);
  EXPECT_TRUE(std::isnan(q[0]) && std::isnan(q[1]));
  EXPECT_NEAR(q[2], 1.169815, 1e-6);
  EXPECT_NEAR(q[3], -0.311857, 1e-6);
  EXPECT_NEAR(q[4], 1.928434, 1e-6);
}

TEST(SelfStarting, AnAlarmedPointDoesNotHideTheNext) {
  std::vector<double> values;
  const RandomStream random(1);
  for (std::uint64_t i = 0; i < 40; ++i) values.push_back(3.0 + 0.1 * random.normal(i));
  values.push_back(1e6);
  values.push_back(3.8);
  const auto q = self_starting(values);
  EXPECT_TRUE(std::isfinite(q[40]) && q[40] > 5.0);
  EXPECT_GT(q[41], 3.0);
}

ControlChart chart_of(const std::vector<ChartPoint>& points, const ChartSettings& settings = {}) {
  static const ChartLimits limits = chart_limits({});
  return control_chart(points, settings, limits);
}

/// `count` results of a unit that changes by `day` from day to day, with uncertainties 0.5 to 2.
std::vector<ChartPoint> history(std::size_t count, double day, std::uint64_t seed) {
  const RandomStream random(seed);
  std::vector<ChartPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double u = 0.5 * std::pow(4.0, random.split("u").uniform(i));
    points.push_back({10.0 + day * random.normal(2 * i) + u * random.normal(2 * i + 1), u});
  }
  return points;
}

TEST(ControlChart, FalseAlarmsAreAsRareAsStated) {
  for (const double day : {0.0, 1.0, 2.0}) {
    int beyond = 0, drifting = 0, shifted = 0;
    constexpr int charts = 200, points = 50;
    for (std::uint64_t seed = 0; seed < charts; ++seed) {
      const auto chart = chart_of(history(30 + points, day, 50 + seed));
      bool any = false;
      shifted += std::ranges::any_of(chart.points, &ChartState::shifted);
      for (std::size_t i = 30; i < chart.points.size(); ++i) {
        beyond += chart.points[i].beyond;
        any = any || chart.points[i].drifting;
      }
      drifting += any;
    }
    // 0.0027 of 10 000 points are 27, four sd more are 48; of the EWMA 0.12 of 200 charts within 50 points
    EXPECT_LE(beyond, 48) << day;
    EXPECT_LE(drifting, 24 + 4 * 5) << day;
    // of the CUSUM 1 - exp(-50/370) = 0.126 of 200 charts
    EXPECT_LE(shifted, 25 + 4 * 5) << day;
  }
}

TEST(ControlChart, ShiftsAndSharedErrors) {
  auto points = history(60, 0.5, 9);
  for (std::size_t i = 40; i < 60; ++i) points[i].value += 4.0;
  const auto shifted = chart_of(points);
  EXPECT_TRUE(shifted.points.back().shifted && shifted.points.back().drifting);
  EXPECT_FALSE(shifted.points[39].shifted);
  EXPECT_FALSE(shifted.points.back().notes.empty());
  for (auto& point : points) point.shared = 10.0;  // a rig that is not the same any more
  EXPECT_FALSE(chart_of(points).points.back().drifting);
  EXPECT_FALSE(chart_of(points).points.back().shifted);
}

TEST(ControlChart, RefusesWhatIsNoChart) {
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"30", "30"}}, [&] { chart_of(history(30, 1.0, 1)); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"30", "2"}},
                      [&] { chart_of(history(30, 1.0, 1), {.baseline = 2}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"0"}, .pattern = "lambda"},
                      [&] { chart_limits({.lambda = 0.0}); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"3"}, .pattern = "without uncertainty"}, [&] {
    chart_of(std::vector<ChartPoint>(5, ChartPoint{1.0, 0.0}), {.baseline = 3});
  }));
}

}  // namespace
}  // namespace tumble
