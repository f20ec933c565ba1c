#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/linear/words.hpp"
#include "tumble/reduce/linear/work.hpp"

namespace tumble::linear {
namespace {

constexpr double stated_sd = 2.0;

/// A bias and segments with these means, of 50 averages each, whose white noise is negligible. The statement: shifts
/// by 2, independent from segment to segment. As many times as `starts` says the unit was switched on.
Work work_with(const std::vector<double>& means, std::size_t starts = 1) {
  constexpr std::size_t averages = 50;
  Work work;
  const std::size_t n = means.size();
  work.data.slow = {{"found", identity(n), 0.0}, {"stated", identity(n), stated_sd * stated_sd, true}};
  for (std::size_t g = 0; g < n; ++g) {
    work.solution.segments.push_back({.duration = averages});
    work.evidence.test.stretches.push_back({.start = g % starts});
    for (std::size_t i = 0; i < averages; ++i) {
      work.data.observations.push_back(means[g]);
      work.data.weights.push_back(1.0);
      work.data.segment.push_back(g);
      work.rows.time.push_back(static_cast<double>(work.rows.time.size()));
    }
  }
  work.data.design = Matrix(n * averages, 1);
  std::ranges::fill(work.data.design.values, 1.0);
  work.solution.fit.white_variance = 1e-6;
  work.solution.fit.slow_variance = {1e6, stated_sd * stated_sd};  // what the fit has found beyond says nothing
  return work;
}

/// Times of the finding; 0: there is none.
double excess_of(Work work) {
  warn_of_excess(Problem{}, work);
  if (work.solution.findings.empty()) return 0.0;
  EXPECT_EQ(work.solution.findings.size(), 1u);
  EXPECT_EQ(work.solution.findings.front().code, "more_drift_than_stated");
  return std::get<double>(work.solution.findings.front().values.front().value);
}

// four means about a bias: their squares, over the stated variance, are chi-square with three degrees of freedom,
// which exceeds 21.11 in one test of 10 000
TEST(Excess, IsSaidFromItsQuantileOn) {
  constexpr double quantile = 21.107513466160846;
  const auto means = [](double share) {
    const double size = stated_sd * std::sqrt(share * quantile / 4.0);
    return std::vector{7.0 + size, 7.0 - size, 7.0 + size, 7.0 - size};
  };
  EXPECT_EQ(excess_of(work_with(means(0.99))), 0.0);
  EXPECT_NEAR(excess_of(work_with(means(1.01))), std::sqrt(1.01 * quantile / 3.0), 1e-3);
}

TEST(Excess, IsNoneOfPowerUpsThatDiffer) {
  const std::vector<double> means{100.0, -100.0, 100.0, -100.0};
  EXPECT_GT(excess_of(work_with(means)), 10.0);
  EXPECT_EQ(excess_of(work_with(means, 2)), 0.0);
}

TEST(Excess, IsNoneWhereTheTermsExplainEveryDifference) { EXPECT_EQ(excess_of(work_with({100.0})), 0.0); }

}  // namespace
}  // namespace tumble::linear
