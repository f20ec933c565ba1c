#include "tumble/math/stability/dynamic_stability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tumble/math/noise_model.hpp"
#include "tumble/math/stability/allan_family.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::vector<double> noise(const NoiseModel& model, std::uint64_t seed, std::size_t samples = 4000) {
  std::vector<double> values(samples, 0.0);
  add_noise(model, 1.0, RandomStream(seed), values);
  return values;
}

/// Of 120 records that do not change no more are called changed at 5 % than 5 % + 4 sd of the binomial, for white noise
/// and flicker some are; of those that grow by 20 % half-way 90 % at 1 % (97 to 100 % of 400 were found).
void expect_test_holds(const NoiseModel& model, bool exact) {
  constexpr int records = 120;
  int false_alarms = 0, found = 0;
  for (std::uint64_t seed = 0; seed < records; ++seed) {
    auto values = noise(model, seed);
    false_alarms += dynamic_allan(values, 1.0, 8, 0.95).chance < 0.05 ? 1 : 0;
    for (std::size_t i = values.size() / 2; i < values.size(); ++i) values[i] *= 1.2;
    found += dynamic_allan(values, 1.0, 8, 0.95).chance < 0.01 ? 1 : 0;
  }
  const double sd = std::sqrt(0.05 * 0.95 * records);
  EXPECT_LT(false_alarms, 0.05 * records + 4.0 * sd);
  if (exact) {
    EXPECT_GT(false_alarms, 0);  // none of 120: 0.2 %
  }
  EXPECT_GT(found, 0.9 * records);
}

TEST(DynamicAllan, TellsNoiseThatChangesFromNoiseThatDoesNot) {
  expect_test_holds({.angle_random_walk = 1.0}, true);
  expect_test_holds({.bias_instability = 1.0}, true);
  expect_test_holds({.angle_random_walk = 1.0, .rate_random_walk = 0.1}, false);
}

TEST(DynamicAllan, WindowsAreRecordsOfTheirOwnAndPointAtTheChange) {
  auto values = noise({.angle_random_walk = 1.0}, 3);
  for (std::size_t i = 3600; i < 3900; ++i) values[i] *= 3.0;
  values[700] = std::numeric_limits<double>::quiet_NaN();
  const auto found = dynamic_allan(values, 1.0, 7, 0.95);
  ASSERT_EQ(found.windows.size(), 7u);
  EXPECT_EQ(found.windows[5].first, 2500u);
  EXPECT_EQ(found.windows[5].size, 1000u);
  EXPECT_EQ(found.worst_window, 6u);
  EXPECT_LT(found.chance, 1e-6);
  EXPECT_GT(found.worst_ratio, 2.0);
  const std::vector<std::size_t> factors{4};
  const auto own = stability_of_rate(Stability::overlapping_allan, std::span(values).subspan(500, 1000), 1.0, factors,
                                     {.confidence = 0.95, .alpha = found.whole[2].alpha});
  const DeviationPoint& point = found.windows[1].points[2];
  EXPECT_NEAR(point.deviation, own.at(0).deviation, 1e-12 * point.deviation);  // two ways to the same sum
  EXPECT_NEAR(point.edf, own.at(0).edf, 1e-12 * point.edf);
  EXPECT_EQ(point.count, own.at(0).count);
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "at least 3 windows"},
                      [&] { dynamic_allan(values, 1.0, 2, 0.95); }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.values = {"14", "32"}}, [&] { dynamic_allan(values, 1.0, 500, 0.95); }));
}

}  // namespace
}  // namespace tumble
