#include "tumble/math/extremes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/random.hpp"

namespace tumble {
namespace {

/// Coarse, so that extremes come again, and one in `gap` missing.
std::vector<double> coarse(std::size_t count, std::uint64_t seed, std::size_t gap) {
  std::vector<double> values(count);
  RandomStream(seed).normal(0, values);
  for (double& value : values) value = std::round(2.0 * value);
  for (std::size_t i = gap; i < count; i += gap) values[i] = NAN;
  return values;
}

TEST(Extremes, AreThoseOfAPlainLoop) {
  for (const std::size_t count : {0, 1, 7, 8, 9, 1023, 1024, 1025, 5000})
    for (const std::size_t gap : {3, 100000}) {
      const auto values = coarse(count, 31 + count, gap);
      Extremes plain;
      for (const double value : values) {
        plain.present += value == value;
        plain.lowest = value < plain.lowest ? value : plain.lowest;
        plain.highest = value > plain.highest ? value : plain.highest;
      }
      const Extremes found = extremes_of(values);
      EXPECT_EQ(found.present, plain.present);
      EXPECT_EQ(found.lowest, plain.lowest);
      EXPECT_EQ(found.highest, plain.highest);
      EXPECT_EQ(found.at_lowest, static_cast<std::size_t>(std::ranges::count(values, plain.lowest)));
      EXPECT_EQ(found.at_highest, static_cast<std::size_t>(std::ranges::count(values, plain.highest)));
    }
}

TEST(Extremes, OfPartsAddUp) {
  const auto values = coarse(3000, 5, 70);
  const Extremes whole = extremes_of(values);
  for (const std::size_t cut : {0, 1, 1000, 3000}) {
    Extremes parts = extremes_of(std::span(values).first(cut));
    parts.add(extremes_of(std::span(values).subspan(cut)));
    EXPECT_EQ(parts.lowest, whole.lowest);
    EXPECT_EQ(parts.at_lowest, whole.at_lowest);
    EXPECT_EQ(parts.highest, whole.highest);
    EXPECT_EQ(parts.at_highest, whole.at_highest);
    EXPECT_EQ(parts.present, whole.present);
  }
}

TEST(Extremes, InfiniteSamplesAreTheExtremes) {
  const Extremes found = extremes_of(std::vector<double>{1.0, INFINITY, NAN, -INFINITY, INFINITY});
  EXPECT_EQ(found.present, 4u);
  EXPECT_EQ(found.highest, INFINITY);
  EXPECT_EQ(found.at_highest, 2u);
  EXPECT_EQ(found.lowest, -INFINITY);
  EXPECT_EQ(found.at_lowest, 1u);
}

TEST(Extremes, GreatestSpikeIsThatOfAPlainLoop) {
  std::vector<double> values(2000);
  RandomStream(77).normal(0, values);
  for (std::size_t i = 0; i < values.size(); i += 130) values[i] = NAN;
  for (const std::size_t begin : {1, 2, 5})
    for (const std::size_t end : {5, 6, 20, 130, 131, 1999}) {
      double greatest = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const double less = std::min(std::abs(values[i] - values[i - 1]), std::abs(values[i] - values[i + 1]));
        if (less > greatest) greatest = less;
      }
      EXPECT_EQ(greatest_spike(values, begin, end), greatest) << begin << " to " << end;
    }
}

}  // namespace
}  // namespace tumble
