#include "tumble/math/population/components.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

TEST(SpreadComponents, AreTheMeanSquaresWhereBalanced) {
  // 3 units on 2 days, 2 results each: mean squares 14.230833, 0.734167, 0.067500
  const ManyResults results{
      {10.1, 10.5, 11.0, 11.2, 13.9, 13.4, 12.7, 13.1, 9.2, 9.0, 10.3, 9.9},
      std::vector<double>(12, 0.0),
      {{"unit", {1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3}}, {"day", {1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6}}}};
  const auto found = components_of_spread(results);
  ASSERT_EQ(found.components.size(), 3u);
  EXPECT_NEAR(square(found.components[0].sd), 3.374167, 1e-6);
  EXPECT_NEAR(square(found.components[1].sd), 0.333333, 1e-6);
  EXPECT_NEAR(square(found.components[2].sd), 0.067500, 1e-6);
  EXPECT_EQ(found.components[2].name, "repeat");
  EXPECT_NEAR(found.mean, 11.191667, 1e-6);
  EXPECT_NEAR(square(found.mean_sd), 14.230833 / 12.0, 1e-6);
  EXPECT_NEAR(found.degrees_of_freedom, 2.0, 1e-4);
}

TEST(SpreadComponents, DoNotDependOnUnitOfMeasureOrOrder) {
  const RandomStream random(5);
  ManyResults results{{}, {}, {{"unit", {}}, {"rig", {}}}};
  for (std::size_t i = 0; i < 40; ++i) {
    results.values.push_back(random.normal(i) + random.split("unit").normal(i / 4) + random.split("rig").normal(i % 3));
    results.sds.push_back(0.2 + 0.1 * random.uniform(i));
    results.factors[0].level.push_back(i / 4);
    results.factors[1].level.push_back(i % 3);
  }
  ManyResults other = results;
  for (auto& value : other.values) value = 1e-6 * value - 4e-5;
  for (auto& sd : other.sds) sd *= 1e-6;
  for (auto* list : {&other.values, &other.sds}) std::ranges::reverse(*list);
  for (auto& factor : other.factors) std::ranges::reverse(factor.level);
  const auto a = components_of_spread(results), b = components_of_spread(other);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(b.components[c].sd, 1e-6 * a.components[c].sd, 1e-11) << a.components[c].name;
    EXPECT_NEAR(b.components[c].upper, 1e-6 * a.components[c].upper, 1e-11) << a.components[c].name;
  }
}

TEST(SpreadComponents, SharedErrorsAreNotSpread) {
  // one rig error of sd 2 that all share moves the mean, and no component
  ManyResults results{
      {1.0, 2.0, 4.0, 3.0, 1.5, 2.5, 3.5, 2.0}, std::vector<double>(8, 0.1), {{"unit", {1, 1, 2, 2, 3, 3, 4, 4}}}};
  const auto alone = components_of_spread(results);
  results.shared = Matrix(8, 1);
  for (std::size_t i = 0; i < 8; ++i) results.shared(i, 0) = 2.0;
  const auto shared = components_of_spread(results);
  EXPECT_NEAR(shared.components[0].sd, alone.components[0].sd, 1e-6);
  EXPECT_NEAR(square(shared.mean_sd), square(alone.mean_sd) + 4.0, 1e-6);
}

TEST(SpreadComponents, RefuseWhatCannotBeSeparatedByName) {
  const std::vector<double> values{1, 2, 3, 4, 5, 6}, sds(6, 0.1);
  const Refused refusal = refusal_of([&] {
    components_of_spread({values,
                          sds,
                          {{"unit", {1, 1, 2, 2, 3, 3}},
                           {"rig", {4, 4, 5, 5, 6, 6}},
                           {"day", {1, 2, 3, 4, 5, 6}},
                           {"site", {1, 1, 1, 1, 1, 1}}}});
  });
  EXPECT_EQ(refusal.problems.size(), 3u);
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      {{.values = {"unit", "rig"}}, {.values = {"day", "day"}}, {.values = {"site"}}}, refusal));
}

/// A fleet: 2 to 4 days a unit of 1 to 3 results, 3 rigs, uncertainties 0.3 to 0.8.
ManyResults fleet(int units, double unit_sd, double day_sd, double rig_sd, const RandomStream& random) {
  ManyResults out{{}, {}, {{"unit", {}}, {"day", {}}, {"rig", {}}}};
  std::size_t day = 0, n = 0;
  for (std::size_t u = 0; u < static_cast<std::size_t>(units); ++u) {
    const auto days = 2 + static_cast<std::size_t>(3.0 * random.split("days").uniform(u));
    for (std::size_t d = 0; d < days; ++d, ++day) {
      const auto repeats = 1 + static_cast<std::size_t>(3.0 * random.split("repeats").uniform(day));
      const auto rig = static_cast<std::size_t>(3.0 * random.split("rig").uniform(day));
      for (std::size_t r = 0; r < repeats; ++r, ++n) {
        const double sd = 0.3 * std::pow(8.0 / 3.0, random.split("u").uniform(n));
        out.values.push_back(unit_sd * random.split("a").normal(u) + day_sd * random.split("b").normal(day) +
                             rig_sd * random.split("c").normal(rig) +
                             std::hypot(0.3, sd) * random.split("e").normal(n));
        out.sds.push_back(sd);
        out.factors[0].level.push_back(u);
        out.factors[1].level.push_back(day);
        out.factors[2].level.push_back(rig);
      }
    }
  }
  return out;
}

TEST(SpreadComponentsCoverage, IntervalsHoldComponentsAndMean) {
  constexpr int fleets = 60;
  int held[4]{}, mean = 0;
  for (std::uint64_t i = 0; i < fleets; ++i) {
    const auto found = components_of_spread(fleet(10, 1.0, 0.5, 0.5, RandomStream(11).split(i)));
    const double truth[]{1.0, 0.5, 0.5, 0.3};
    for (int c = 0; c < 4; ++c)
      held[c] += found.components[c].lower <= truth[c] && truth[c] <= found.components[c].upper;
    mean += found.mean_lower <= 0.0 && 0.0 <= found.mean_upper;
  }
  for (int c = 0; c < 4; ++c) EXPECT_GE(held[c], 50) << c;  // 0.95 of 60 less four sd
  EXPECT_GE(mean, 50);
}

}  // namespace
}  // namespace tumble
