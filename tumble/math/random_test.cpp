#include "tumble/math/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <vector>

namespace tumble {
namespace {

constexpr std::size_t many = 1'000'000;

std::vector<double> normals(const RandomStream& stream, std::uint64_t first, std::size_t count) {
  std::vector<double> values(count);
  stream.normal(first, values);
  return values;
}

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// sqrt(n) times the greatest distance between the empirical and the given distribution (Kolmogorov).
double kolmogorov(std::vector<double> values, const std::function<double(double)>& cdf) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double p = cdf(values[i]);
    worst = std::max({worst, p - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - p});
  }
  return worst * std::sqrt(n);
}

/// 2 exp(-2 x^2) = 6.3e-5, the chance of 4 sigma on two sides.
const double kolmogorov_limit = std::sqrt(std::log(2.0 / 6.3e-5) / 2.0);

// Against Philox4x32-10 and Box-Muller in 40-digit arithmetic (mpmath). Tolerance: the logarithm to 1e-15 relative and
// the circle to 3e-16, times a radius below 3, and the last rounding: 4e-15.
TEST(RandomStream, FollowsItsDefinition) {
  const RandomStream stream(20240601);
  EXPECT_NEAR(stream.normal(0), -2.3860378683032803219, 4e-15);
  EXPECT_NEAR(stream.normal(1), 1.0091629926165501207, 4e-15);
  EXPECT_NEAR(stream.normal(2), 1.3070322111383810687, 4e-15);
  EXPECT_NEAR(stream.normal(5), -0.40652781137323716379, 4e-15);
  EXPECT_NEAR(stream.normal(2 * 12345678901), 1.3034318631024936996, 4e-15);
  EXPECT_NEAR(stream.normal(0x8000'0000'0000'0001u), 0.050470698558638473996, 4e-15);
  EXPECT_EQ(stream.uniform(0), 0.88037342869069712403);
  EXPECT_EQ(stream.uniform(3), 0.27168673962622957863);
  EXPECT_EQ(stream.uniform(0x8000'0000'0000'0001u), 0.71353868882841464671);
}

TEST(RandomStream, AnyPartIsThatPartOfTheWhole) {
  const RandomStream stream = RandomStream(7).split("gyro");
  const auto whole = normals(stream, 0, 3000);
  for (const std::size_t first : {0u, 1u, 2u, 17u, 255u, 256u, 257u, 1000u})
    for (const std::size_t count : {0u, 1u, 2u, 3u, 255u, 256u, 257u, 258u, 1301u}) {
      const auto part = normals(stream, first, count);
      ASSERT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + static_cast<long>(first)));
    }
  for (std::size_t i = 0; i < whole.size(); ++i) ASSERT_EQ(stream.normal(i), whole[i]);
}

// Moments of n standard normal numbers: var(m1) = 1/n, var(m2) = 2/n, var(m3) = 15/n, var(m4) = 96/n; 4 sigma.
TEST(RandomStream, MomentsOfTheNormal) {
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  for (const double x : normals(RandomStream(1), 0, many)) m1 += x, m2 += x * x, m3 += x * x * x, m4 += x * x * x * x;
  const double n = many;
  EXPECT_NEAR(m1 / n, 0.0, 4 * std::sqrt(1 / n));
  EXPECT_NEAR(m2 / n, 1.0, 4 * std::sqrt(2 / n));
  EXPECT_NEAR(m3 / n, 0.0, 4 * std::sqrt(15 / n));
  EXPECT_NEAR(m4 / n, 3.0, 4 * std::sqrt(96 / n));
}

TEST(RandomStream, DistributionsOfNormalAndUniform) {
  const RandomStream stream(2);
  const auto values = normals(stream, 0, many);
  EXPECT_LT(kolmogorov(values, normal_cdf), kolmogorov_limit);
  std::vector<double> squared, turn, uniform;
  for (std::size_t i = 0; i < many; i += 2) {
    squared.push_back(std::hypot(values[i], values[i + 1]));
    turn.push_back(std::atan2(values[i], values[i + 1]));
    uniform.push_back(stream.uniform(i / 2));
  }
  EXPECT_LT(kolmogorov(squared, [](double r) { return 1.0 - std::exp(-r * r / 2); }), kolmogorov_limit);
  EXPECT_LT(kolmogorov(turn, [](double a) { return 0.5 + a / (2 * std::numbers::pi); }), kolmogorov_limit);
  EXPECT_LT(kolmogorov(uniform, [](double u) { return u; }), kolmogorov_limit);
}

// Beyond 4.5 sigma stand n p numbers of n, p = 6.795e-6, give or take its root: 4 sigma.
TEST(RandomStream, TailsAreFull) {
  constexpr double n = 1e7, expected = n * 6.795346249460121e-6;
  std::size_t beyond = 0;
  for (int part = 0; part < 10; ++part)
    for (const double x : normals(RandomStream(3), part * many, many)) beyond += std::abs(x) > 4.5;
  EXPECT_NEAR(static_cast<double>(beyond), expected, 4 * std::sqrt(expected));
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum / static_cast<double>(a.size());
}

// The correlation of independent streams of n numbers has the standard deviation 1/sqrt(n): 4 sigma.
TEST(RandomStream, StreamsAreIndependent) {
  const RandomStream root(4);
  const double limit = 4 / std::sqrt(1e5);
  std::vector<std::vector<double>> all;
  for (const auto& stream : {root, RandomStream(5), root.split("a"), root.split("b"), root.split(0), root.split(1),
                             root.split("a").split("b"), root.split("b").split("a"), root.split("ab")})
    all.push_back(normals(stream, 0, 100'000));
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_LT(std::abs(correlation(all[i], all[j])), limit) << i << " " << j;
  std::vector<double> shifted(all[0].begin() + 1, all[0].end());
  shifted.push_back(0.0);
  EXPECT_LT(std::abs(correlation(all[0], shifted)), limit);
}

TEST(RandomStream, SplittingIsRepeatableAndDistinct) {
  const RandomStream root(6);
  EXPECT_EQ(root.split("run 1").normal(9), root.split("run 1").normal(9));
  std::set<double> firsts;
  for (int i = 0; i < 1000; ++i) {
    firsts.insert(root.split(static_cast<std::uint64_t>(i)).normal(0));
    firsts.insert(root.split(std::to_string(i)).normal(0));
    firsts.insert(RandomStream(static_cast<std::uint64_t>(i) + 100).normal(0));
  }
  EXPECT_EQ(firsts.size(), 3000u);
}

}  // namespace
}  // namespace tumble
