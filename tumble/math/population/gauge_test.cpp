#include "tumble/math/population/gauge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tumble/math/random.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Variances: repeats 0.09, units on rigs 0.01, rigs 0.04, units 1.
std::vector<double> study(std::size_t units, std::size_t rigs, std::size_t repeats, const RandomStream& random) {
  std::vector<double> values;
  for (std::size_t i = 0; i < units; ++i)
    for (std::size_t j = 0; j < rigs; ++j)
      for (std::size_t k = 0; k < repeats; ++k)
        values.push_back(random.split("unit").normal(i) + 0.2 * random.split("rig").normal(j) +
                         0.1 * random.split("both").normal(i * rigs + j) + 0.3 * random.normal(values.size()));
  return values;
}

TEST(Gauge, ComponentsAreUnbiasedAndIntervalsHold) {
  constexpr int studies = 200;
  double repeat = 0.0, units = 0.0;
  int gauge = 0, share = 0;
  for (std::uint64_t i = 0; i < studies; ++i) {
    const auto values = study(10, 3, 3, RandomStream(4).split(i));
    const auto found = gauge_of({10, 3, 3, values});
    repeat += square(found.repeatability.value) / studies;
    units += square(found.units.value) / studies;
    const double truth = std::sqrt(0.09 + 0.01 + 0.04);
    gauge += found.gauge.lower <= truth && truth <= found.gauge.upper;
    share += found.share.lower <= truth / std::hypot(truth, 1.0) && truth / std::hypot(truth, 1.0) <= found.share.upper;
  }
  EXPECT_NEAR(repeat, 0.09, 4.0 * 0.09 * std::sqrt(2.0 / 60.0 / studies));
  EXPECT_NEAR(units, 1.0, 4.0 * 1.1 * std::sqrt(2.0 / 9.0 / studies));
  EXPECT_NEAR(gauge / 200.0, 0.95, 0.062);  // four sd of 200 studies
  EXPECT_NEAR(share / 200.0, 0.95, 0.062);
}

TEST(Gauge, OfThreeRigsSaysLittle) {
  const auto values = study(10, 3, 3, RandomStream(4));
  const auto found = gauge_of({10, 3, 3, values});
  EXPECT_GT(found.share.upper, 1.5 * found.share.lower);
  EXPECT_GE(found.categories, 2.0);
}

TEST(Gauge, RefusesAnIncompleteStudy) {
  const std::vector<double> values(11, 1.0);
  try {
    gauge_of({1, 3, 4, values});
    FAIL() << "an incomplete study was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.size(), 2u);
  }
}

}  // namespace
}  // namespace tumble
