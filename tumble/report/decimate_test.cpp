#include "tumble/report/decimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/report/testing/example_estimate.hpp"

namespace tumble {
namespace {

TEST(PointsToDraw, KeepsShortCurvesWhole) {
  const std::vector<double> x{1, 2, 3}, y{4, 5, 6};
  EXPECT_EQ(points_to_draw(x, y, {}, {}, false), (std::vector<std::size_t>{0, 1, 2}));
}

TEST(PointsToDraw, KeepsEndsPeaksAndGapsOfLongOnes) {
  for (const bool logarithmic : {false, true}) {
    std::vector<double> x, y, lower, upper;
    for (int i = 0; i < 100000; ++i) {
      x.push_back(1.0 + i);
      y.push_back(testing::wiggle(i));
      lower.push_back(y.back() - 0.1);
      upper.push_back(y.back() + 0.1);
    }
    y[41234] = 7.0;
    y[70001] = -7.0;
    y[55555] = NAN;
    lower[333] = -9.0;
    upper[99998] = 9.0;
    const auto indices = points_to_draw(x, y, lower, upper, logarithmic);
    EXPECT_LE(indices.size(), 5002u);  // at most five a stretch, and the ends
    EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
    for (const std::size_t must : {0u, 333u, 41234u, 55555u, 70001u, 99998u, 99999u}) {
      EXPECT_TRUE(std::binary_search(indices.begin(), indices.end(), must)) << must;
    }
  }
}

TEST(PointsToDraw, CurvesThatRunBackKeepTheirOrder) {
  std::vector<double> x, y;
  for (int i = 0; i < 20000; ++i) {
    x.push_back(std::sin(0.001 * i));
    y.push_back(std::cos(0.001 * i));
  }
  const auto indices = points_to_draw(x, y, {}, {}, false);
  EXPECT_LE(indices.size(), 5000u);
  EXPECT_GT(indices.size(), 1000u);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
}

}  // namespace
}  // namespace tumble
