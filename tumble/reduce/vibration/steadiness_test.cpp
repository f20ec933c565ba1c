#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/reduce/vibration/faults.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::vibration_test {
namespace {

using namespace tumble::vibration;

/// A rest of 10 s and a random vibration of 40 s at 100 Hz, whose size each window gives.
template <class Size>
Data vibrating(const Size& size) {
  Data data;
  data.units.push_back({.name = "A"});
  const RandomStream random(3);
  const auto add = [&](const std::string& label, std::size_t n, double begin, const auto& of) {
    Series series{
        .label = label, .window = 0.01, .interval = 0.01, .begin = begin, .end = begin + 0.01 * static_cast<double>(n)};
    for (std::size_t j = 0; j < n; ++j) {
      series.time.push_back(begin + 0.01 * (static_cast<double>(j) + 0.5));
      series.force.push_back(of(static_cast<double>(j) / static_cast<double>(n)) * random.split(label).normal(j));
    }
    data.series.push_back(std::move(series));
  };
  add("rest", 1000, 0.0, [](double) { return 1e-3; });
  add("random", 4000, 10.0, size);
  data.series.back().shake = {
      .kind = Motion::Kind::random, .psd_frequency = {5.0, 45.0}, .psd = {1.0 / 40.0, 1.0 / 40.0}};
  return data;
}

bool has(const Data& data, const char* code) {
  return std::ranges::find(data.findings, code, &Finding::code) != data.findings.end();
}

TEST(Steadiness, ASteadyVibrationIsLeftAsItIs) {
  for (int seed = 0; seed < 3; ++seed) {
    Data data = vibrating([](double) { return 1.0; });
    cut_to_vibrations(data);
    drop_still(data);
    check_ramps(data);
    EXPECT_EQ(data.series[1].force.size(), 4000u);
    EXPECT_TRUE(data.findings.empty());
  }
}

TEST(Steadiness, AVibrationThatBeginsLateAndEndsEarlyIsCut) {
  Data data = vibrating([](double part) { return part < 0.05 || part > 0.9 ? 1e-3 : 1.0; });
  cut_to_vibrations(data);
  EXPECT_TRUE(has(data, "vibration_not_throughout"));
  EXPECT_NEAR(data.series[1].begin, 12.0, 0.7);
  EXPECT_NEAR(data.series[1].end, 46.0, 0.7);
  EXPECT_GT(data.series[1].begin, 12.0);
  EXPECT_LT(data.series[1].end, 46.0);
  EXPECT_EQ(data.series[1].time.size(), data.series[1].force.size());
  EXPECT_NEAR(data.series[1].time.front(), data.series[1].begin + 0.005, 1e-9);
}

TEST(Steadiness, AVibrationThatGrowsIsNamed) {
  Data data = vibrating([](double part) { return 1.0 + 0.5 * part; });
  check_ramps(data);
  EXPECT_TRUE(has(data, "vibration_not_steady"));
}

TEST(Steadiness, AVibrationThatIsNotThereIsSkipped) {
  Data data = vibrating([](double) { return 1e-3; });
  drop_still(data);
  EXPECT_TRUE(has(data, "vibration_absent"));
  EXPECT_EQ(data.series.size(), 1u);
}

TEST(Rests, AUnitTurnedOverIsFoundBesideOneThatCountsUp) {
  Data data;
  for (const double scale : {-5e-4, 4e-4}) {
    data.units.push_back({.name = "A", .force_per_value = scale, .scale_from_rest = true});
    data.series.push_back({.unit = data.units.size() - 1, .rest = standard_gravity});
  }
  Settings settings;
  settings.set_number("bias_sd", 0.05, Unit::parse("m/s^2"));
  compare_rests(settings, data);
  ASSERT_EQ(data.departures.size(), 1u);
  EXPECT_EQ(data.departures[0].unit, 0u);
  EXPECT_LT(data.departures[0].ratio(), -0.5);
  data.departures.clear();
  data.units[1].force_per_value = -4e-4;  // both count down: they are built so
  compare_rests(settings, data);
  EXPECT_TRUE(data.departures.empty());
}

}  // namespace
}  // namespace tumble::vibration_test
