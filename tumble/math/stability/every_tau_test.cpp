#include "tumble/math/stability/every_tau.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <span>

#include "tumble/math/stability/allan.hpp"
#include "tumble/math/stability/allan_family.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/stability/lagged_products.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace every_tau_test {
namespace {

using tumble::every_overlapping_allan;
using tumble::every_overlapping_hadamard;
using tumble::EveryTau;

/// Deviation from the sum as it is defined, in long double over the same phase.
double direct(std::span<const double> x, std::size_t m) {
  long double sum = 0.0L;
  for (std::size_t n = 0; n + 2 * m < x.size(); ++n) {
    const long double z = static_cast<long double>(x[n]) - 2.0L * x[n + m] + x[n + 2 * m];
    sum += z * z;
  }
  return static_cast<double>(std::sqrt(sum / (2.0L * static_cast<long double>(x.size() - 2 * m))) / m);
}

double direct_third(std::span<const double> x, std::size_t m) {
  long double sum = 0.0L;
  for (std::size_t n = 0; n + 3 * m < x.size(); ++n) {
    const long double z = static_cast<long double>(x[n + 3 * m]) - 3.0L * x[n + 2 * m] + 3.0L * x[n + m] - x[n];
    sum += z * z;
  }
  return static_cast<double>(std::sqrt(sum / (6.0L * static_cast<long double>(x.size() - 3 * m))) / m);
}

/// White, and its running sum once and twice, as rates of different noise.
std::vector<double> record(std::size_t samples,
                           const std::function<double(std::size_t, double, double, double)>& rate) {
  std::mt19937_64 engine(71);
  std::normal_distribution<double> normal;
  std::vector<double> y(samples);
  double walk = 0.0, twice = 0.0;
  for (std::size_t n = 0; n < samples; ++n) {
    const double white = normal(engine);
    twice += walk += white;
    y[n] = rate(n, white, walk, twice);
  }
  return y;
}

struct Case {
  const char* name;
  std::function<double(std::size_t, double, double, double)> rate;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"white rate", [](std::size_t, double white, double, double) { return white; }},
      {"random walk", [](std::size_t, double, double walk, double) { return walk; }},
      {"random run", [](std::size_t, double, double, double twice) { return twice; }},
      {"large mean", [](std::size_t, double white, double walk, double) { return 1e6 + white + 1e-2 * walk; }},
      {"large drift", [](std::size_t n, double white, double, double) { return 0.1 * static_cast<double>(n) + white; }},
      {"bursts", [](std::size_t n, double white, double, double) { return n % 5003 == 7 ? 1e5 : white; }},
  };
  return all;
}

/// `every` of the record, differences of this order, against the sum at these factors.
void expect_same(const EveryTau& every, std::size_t order, double (*direct_sum)(std::span<const double>, std::size_t),
                 const std::vector<double>& rate, const std::vector<std::size_t>& factors, const char* name) {
  const auto phase = tumble::integrate_rate(rate, 3);
  ASSERT_EQ(every.deviation.size(), rate.size() / order);
  for (const std::size_t m : factors) {
    const double expected = direct_sum(phase.values, m);
    EXPECT_NEAR(every.deviation[m - 1] / expected, 1.0, every.rounding[m - 1]) << name << ", m = " << m;
    EXPECT_LE(every.rounding[m - 1], 1e-9) << name << ", m = " << m;
    EXPECT_EQ(every.count[m - 1], phase.values.size() - order * m);
  }
}

void expect_direct(const std::vector<double>& rate, const std::vector<std::size_t>& factors, const char* name) {
  expect_same(every_overlapping_allan(rate), 2, direct, rate, factors, name);
}

void expect_direct_third(const std::vector<double>& rate, const std::vector<std::size_t>& factors, const char* name) {
  expect_same(every_overlapping_hadamard(rate), 3, direct_third, rate, factors, name);
}

}  // namespace

TEST(EveryTau, OfTheHadamardDeviationIsTheDirectSum) {
  for (const auto& [name, rate] : cases()) {
    std::vector<std::size_t> factors(1000), few = tumble::averaging_factors(33335, 12.0);
    for (std::size_t m = 1; m <= factors.size(); ++m) factors[m - 1] = m;
    expect_direct_third(record(3001, rate), factors, name);
    for (std::size_t k = 1; k < 4; ++k) few.push_back(33335 - k);
    expect_direct_third(record(100007, rate), few, name);
  }
  for (std::size_t samples = 3; samples < 14; ++samples) {
    std::vector<std::size_t> factors(samples / 3);
    for (std::size_t m = 1; m <= factors.size(); ++m) factors[m - 1] = m;
    expect_direct_third(record(samples, cases()[0].rate), factors, "short");
  }
}

TEST(EveryTau, OfTheHadamardDeviationLeavesOutTermsAcrossGaps) {
  auto rate = record(4000, cases()[1].rate);
  for (const std::size_t n : {50, 1800, 1801, 3991}) rate[n] = std::numeric_limits<double>::quiet_NaN();
  const auto every = every_overlapping_hadamard(rate);
  std::vector<std::size_t> factors;
  for (std::size_t m = 1; m <= 700; m += 9) factors.push_back(m);
  const auto points =
      tumble::stability_of_rate(tumble::Stability::overlapping_hadamard, rate, 1.0, factors, {.alpha = -2});
  ASSERT_EQ(points.size(), factors.size());
  for (const auto& point : points) {
    EXPECT_NEAR(every.deviation[point.factor - 1] / point.deviation, 1.0, 2e-10) << point.factor;
    EXPECT_EQ(every.count[point.factor - 1], point.count) << point.factor;
  }
  EXPECT_EQ(every.count.back(), 0u);
}

TEST(EveryTau, IsTheDirectSumAtEveryFactor) {
  for (const auto& [name, rate] : cases()) {
    std::vector<std::size_t> factors;
    for (std::size_t m = 1; m <= 1500; ++m) factors.push_back(m);
    expect_direct(record(3001, rate), factors, name);
  }
}

TEST(EveryTau, IsTheDirectSumOfLongRecords) {
  for (const auto& [name, rate] : cases()) {
    auto factors = tumble::averaging_factors(100003, 12.0);
    for (std::size_t k = 0; k < 4; ++k) factors.push_back(100003 - k);
    expect_direct(record(200007, rate), factors, name);
  }
}

TEST(EveryTau, StatesItsRoundingWhereTheSumVanishes) {
  // A sine has next to no difference at multiples of its period: there the sum is a remainder of large numbers.
  const auto rate = record(20000, [](std::size_t n, double white, double, double) {
    return std::sin(0.0314159265358979 * static_cast<double>(n)) + 1e-6 * white;
  });
  const auto every = every_overlapping_allan(rate);
  const auto phase = tumble::integrate_rate(rate, 3);
  for (std::size_t m = 1; m <= 10000; m += 37) {
    const double expected = direct(phase.values, m);
    EXPECT_NEAR(every.deviation[m - 1] / expected, 1.0, every.rounding[m - 1]) << m;
  }
}

TEST(EveryTau, LeavesOutTermsAcrossGaps) {
  auto rate = record(9000, cases()[3].rate);
  const double missing = std::numeric_limits<double>::quiet_NaN();
  for (const std::size_t n : {100, 4000, 4001, 8990}) rate[n] = missing;
  const auto every = every_overlapping_allan(rate);
  const auto points =
      tumble::overlapping_allan(rate, 1.0, {.points_per_decade = 20.0, .confidence = 0.95, .longest_fraction = 0.5});
  ASSERT_GT(points.size(), 50u);
  for (const auto& point : points) {
    EXPECT_NEAR(every.deviation[point.factor - 1] / point.deviation, 1.0, 2e-10) << point.factor;
    EXPECT_EQ(every.count[point.factor - 1], point.count) << point.factor;
  }
  EXPECT_EQ(every.count.back(), 0u);
  EXPECT_EQ(every.deviation.back(), 0.0);
}

TEST(EveryTau, TakesTheShortestRecords) {
  for (std::size_t samples = 3; samples < 12; ++samples) {
    std::vector<std::size_t> factors;
    for (std::size_t m = 1; m <= samples / 2; ++m) factors.push_back(m);
    expect_direct(record(samples, cases()[0].rate), factors, "short");
  }
  EXPECT_TRUE(tumble::refuses(tumble::Error::Kind::bad_data, tumble::Asked{.values = {"3", "2"}}, [&] {
    every_overlapping_allan(std::vector<double>{1.0, 2.0});
  }));
  const auto constant = every_overlapping_allan(std::vector<double>(1000, 3.0));
  for (const double deviation : constant.deviation) EXPECT_EQ(deviation, 0.0);
}

TEST(LaggedProducts, AreTheSumsTheyAreDefinedAs) {
  for (const std::size_t size : {1, 2, 5, 129, 700, 20000}) {
    const auto x = record(size, cases()[1].rate);
    const std::size_t longest = size / 2, stride = 1 + longest / 100;
    double squares = 0.0;
    for (const double value : x) squares += value * value;
    const auto found = tumble::lagged_products(x, longest, true);
    ASSERT_EQ(found.whole.size(), 2 * longest + 1);
    ASSERT_EQ(found.leading.size(), longest + 1);
    for (std::size_t lag = 0; lag <= 2 * longest; lag += stride) {
      long double whole = 0.0L, leading = 0.0L, trailing = 0.0L;
      for (std::size_t i = 0; i + lag < size; ++i) whole += static_cast<long double>(x[i]) * x[i + lag];
      EXPECT_NEAR(found.whole[lag], static_cast<double>(whole), 2e-15 * squares) << size << ", " << lag;
      if (lag > longest) continue;
      for (std::size_t i = 0; i < lag; ++i) {
        leading += static_cast<long double>(x[i]) * x[i + lag];
        trailing += static_cast<long double>(x[size - 1 - i]) * x[size - 1 - i - lag];
      }
      EXPECT_NEAR(found.leading[lag], static_cast<double>(leading), 1e-15 * squares) << size << ", " << lag;
      EXPECT_NEAR(found.trailing[lag], static_cast<double>(trailing), 1e-15 * squares) << size << ", " << lag;
    }
  }
}

TEST(LaggedProducts, OfThirdDifferencesAreTheSumsTheyAreDefinedAs) {
  for (const std::size_t size : {4, 7, 700, 9001}) {
    const auto x = record(size, cases()[1].rate);
    const std::size_t longest = (size - 1) / 3, stride = 1 + longest / 100;
    double squares = 0.0;
    for (const double value : x) squares += value * value;
    const auto found = tumble::third_products(x, longest, true);
    ASSERT_EQ(found.whole.size(), 3 * longest + 1);
    for (std::size_t m = 0; m <= longest; m += stride) {
      for (const bool backwards : {false, true}) {
        const auto at = [&](std::size_t i) { return static_cast<long double>(backwards ? x[size - 1 - i] : x[i]); };
        const auto sum = [&](std::size_t count, std::size_t lag) {
          long double total = 0.0L;
          for (std::size_t i = 0; i < count; ++i) total += at(i) * at(i + lag);
          return static_cast<double>(total);
        };
        const auto& ends = backwards ? found.trailing : found.leading;
        EXPECT_NEAR(ends.one[m], sum(m, m), 1e-15 * squares) << size << ", " << m;
        EXPECT_NEAR(ends.two[m], sum(2 * m, m), 2e-15 * squares) << size << ", " << m;
        EXPECT_NEAR(ends.half[m], sum(m, 2 * m), 1e-15 * squares) << size << ", " << m;
        EXPECT_NEAR(found.whole[3 * m], sum(size - 3 * m, 3 * m), 2e-15 * squares) << size << ", " << m;
      }
    }
  }
}

}  // namespace every_tau_test
