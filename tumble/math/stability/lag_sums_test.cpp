#include "tumble/math/stability/lag_sums.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_differences.hpp"

namespace {

using tumble::averaging_factors;

std::vector<double> walk(std::size_t size) {
  std::mt19937_64 generator(size);
  std::normal_distribution<double> step;
  std::vector<double> x(size);
  double at = 0.0;
  for (double& value : x) value = at += step(generator);
  return x;
}

/// As defined, in long double.
tumble::LagSum direct(const std::vector<double>& x, std::size_t m) {
  long double all = 0.0L, inner = 0.0L;
  for (std::size_t n = 0; n + m < x.size(); ++n) {
    const long double d = static_cast<long double>(x[n + m]) - x[n];
    all += d * d;
    if (n + 2 * m < x.size()) inner += d * d;
    if (n >= m) inner += d * d;
  }
  return {static_cast<double>(all), static_cast<double>(inner)};
}

long double direct_second(const std::vector<double>& x, std::size_t m) {
  long double sum = 0.0L;
  for (std::size_t n = 0; n + 2 * m < x.size(); ++n) {
    const long double z = static_cast<long double>(x[n]) - 2.0L * x[n + m] + x[n + 2 * m];
    sum += z * z;
  }
  return sum;
}

// Sizes with one block, with levels of which the last takes all rows, with a last row that is short by 1, 5 or 13
// values or not at all, so that the columns end in whole lines or do not.
TEST(LagSums, AreThoseOfTheDefinition) {
  for (const std::size_t size :
       {2u, 3u, 40u, 2048u, 5000u, 65536u, 65537u, 131072u, 300007u, 524301u, 2097152u + 13u}) {
    const auto x = walk(size);
    auto lags = averaging_factors(size - 1, 16.6);
    std::erase_if(lags, [&](std::size_t lag) { return !tumble::has_lag_sum(size, lag); });
    const auto found = tumble::lag_sums(x, lags);
    for (std::size_t i = 0; i<lags.size(); i += size> 100000 ? 5 : 1) {
      const auto expected = direct(x, lags[i]);
      EXPECT_NEAR(found[i].all, expected.all, 1e-13 * expected.all) << size << " at lag " << lags[i];
      EXPECT_NEAR(found[i].inner, expected.inner, 1e-13 * expected.all) << size << " at lag " << lags[i];
    }
  }
}

TEST(LagSums, TakeTheFactorsOfAnyNumberADecadeAndTheirDoubles) {
  for (const double points_per_decade : {0.0, 4.0, 10.0, 16.6, 30.0, 53.0})
    for (const std::size_t size : {std::size_t{1000}, std::size_t{70001}, std::size_t{10000001}, std::size_t{1} << 30})
      for (const std::size_t m : averaging_factors(size / 2, points_per_decade))
        EXPECT_TRUE(tumble::has_lag_sum(size, m) && tumble::has_lag_sum(size, 2 * m)) << size << " at " << m;
}

// Where a drift exceeds the noise the sums over lags lose digits, and odd factors have none: both are summed directly.
TEST(LagSums, LeaveToTheDirectSumWhatTheyCannotResolve) {
  constexpr std::size_t size = 150001;
  for (const double drift : {0.0, 1e-7, 1e-3}) {
    auto x = walk(size);
    for (std::size_t n = 0; n < size; ++n) x[n] += drift * static_cast<double>(n) * (static_cast<double>(n) - 1.5e5);
    auto factors = averaging_factors(size / 2, 4.0);
    factors.insert(factors.end(), {1001, 50021, 74999});
    std::sort(factors.begin(), factors.end());
    std::vector<double> sums(factors.size(), 0.0);
    tumble::add_second_differences(x, factors, sums);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const auto expected = static_cast<double>(direct_second(x, factors[i]));
      EXPECT_NEAR(sums[i], expected, 1e-10 * expected) << drift << " at " << factors[i];
    }
  }
}

// Squares that are equal round in one direction: phase with a slope and a glitch now and then, or a rate that is turned
// over. Chains of a few thousand additions lost 2e-10 of a deviation here.
TEST(LagSums, HoldWhereAllSquaresRoundInOneDirection) {
  constexpr std::size_t size = 4000000, m = 16384;
  for (const double rate : {1.15, 1.35, 1.6}) {
    std::mt19937_64 generator(size);
    std::normal_distribution<double> glitch(0.0, rate * m / 6.0);  // few enough to leave it to the lag sums
    std::vector<double> x(size);
    for (std::size_t n = 0; n < size; ++n)
      x[n] = rate * static_cast<double>(n) + (n % 997 == 500 ? glitch(generator) : 0.0);
    std::array<double, 2> sums{};
    tumble::add_second_differences(x, std::array{m, 2 * m}, sums);
    const auto expected = static_cast<double>(direct_second(x, m));
    EXPECT_NEAR(sums[0], expected, 2e-10 * expected) << rate;
  }
}

}  // namespace
