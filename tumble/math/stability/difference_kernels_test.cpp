// The loops of every processor that this one can stand for, against those of the newest: the same bits.

#include "tumble/math/stability/difference_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

namespace tumble {
namespace {

constexpr std::array<std::size_t, 12> lags{1, 2, 3, 5, 8, 16, 21, 64, 100, 256, 300, 511};

std::vector<double> walk(std::size_t size) {
  std::mt19937_64 generator(size);
  std::normal_distribution<double> step;
  std::vector<double> x(size);
  double at = 0.0;
  for (double& value : x) value = at += step(generator);
  return x;
}

/// Sums over all lags, as many together as the kernels take, added to what is there.
std::array<EightSums, lags.size()> lag_sums_of(const DifferenceKernels& kernels, const double* x, std::size_t count) {
  std::array<EightSums, lags.size()> sums;
  sums[3].values[5] = 1e3;
  std::array<std::size_t, lags.size()> into;
  std::iota(into.rbegin(), into.rend(), std::size_t{0});
  for (std::size_t g = 0; g < lags.size(); g += kernels.most_together) {
    const std::size_t together = std::min(kernels.most_together, lags.size() - g);
    kernels.add_lags[together - 1](x, lags.data() + g, into.data() + g, count, sums.data());
  }
  return sums;
}

void expect_near(double found, double expected) { EXPECT_NEAR(found, expected, 1e-14 * expected); }

// Counts that end in whole lanes and in each part of them, from places that lie on no line of the cache too. Kernels
// that round alike give the same bits. Else each addition differs by half an epsilon of the sum at most, in either
// direction: 1e-14 are 6 standard deviations of 250 in one lane.
TEST(DifferenceKernels, OfEveryProcessorGiveTheSameBits) {
  const auto x = walk(4096);
  const auto& last = all_difference_kernels().back();
  for (const auto& kernels : all_difference_kernels()) {
    for (std::size_t count = 0; count <= 2000; count += count < 40 ? 1 : 97) {
      const double* const from = x.data() + count % 7;
      const auto expected = lag_sums_of(last, from, count), found = lag_sums_of(kernels, from, count);
      for (std::size_t g = 0; g < lags.size(); ++g)
        for (std::size_t lane = 0; lane < 8; ++lane) {
          if (kernels.fused == last.fused) {
            EXPECT_EQ(found[g].values[lane], expected[g].values[lane]) << count;
          }
          expect_near(found[g].values[lane], expected[g].values[lane]);
        }
      for (const std::size_t m : lags) {
        const double one = kernels.second_differences(from, m, count), two = last.second_differences(from, m, count);
        if (kernels.fused == last.fused) {
          EXPECT_EQ(one, two) << m;
        }
        expect_near(one, two);
      }
    }
  }
}

TEST(DifferenceKernels, OfEveryProcessorPutTheSameLines) {
  constexpr std::size_t rows = 6, step = 97;
  const auto x = walk(1000);
  for (const auto& kernels : all_difference_kernels()) {
    for (const std::size_t lines : {std::size_t{1}, std::size_t{3}, DifferenceKernels::many_lines}) {
      std::vector<Line> tile(rows * lines);
      kernels.put_lines(x.data(), step, rows, lines, tile.data());
      for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < 8 * lines; ++column)
          EXPECT_EQ(tile[column / 8 * rows + row].values[column % 8], x[row * step + column]);
    }
  }
}

TEST(DifferenceKernels, GiveTheSumsOfTheDefinition) {
  const auto x = walk(4096);
  const std::size_t count = 1001, m = 300;
  long double first = 0.0L, second = 0.0L;
  for (std::size_t n = 0; n < count; ++n) {
    const long double d = static_cast<long double>(x[n + m]) - x[n], z = x[n] - 2.0L * x[n + m] + x[n + 2 * m];
    first += d * d;
    second += z * z;
  }
  const auto sums = lag_sums_of(difference_kernels(), x.data(), count)[1].values;  // of the last lag but one: 300
  EXPECT_NEAR(std::accumulate(sums.begin(), sums.end(), 0.0), static_cast<double>(first),
              1e-13 * static_cast<double>(first));
  EXPECT_NEAR(difference_kernels().second_differences(x.data(), m, count), static_cast<double>(second),
              1e-13 * static_cast<double>(second));
}

}  // namespace
}  // namespace tumble
