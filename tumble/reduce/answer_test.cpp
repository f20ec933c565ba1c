#include "tumble/reduce/answer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Matrix columns(std::size_t rows, std::vector<double> values) {
  Matrix m(rows, values.size() / rows);
  m.values = std::move(values);
  return m;
}

Estimate two_parameters() {
  Estimate estimate;
  estimate.parameters = {{"bias", "K0", Unit::parse("ug"), 1.0, ""}, {"scale", "K1", Unit::parse("ppm"), 2.0, ""}};
  return estimate;
}

void expect_covariance(const Matrix& c, const std::vector<double>& values) {
  ASSERT_EQ(c.values.size(), values.size());
  for (std::size_t k = 0; k < values.size(); ++k) EXPECT_NEAR(c.values[k], values[k], 1e-13 * 60.0) << k;
}

// The worked example of docs/equations (8.2): noise diag(4, 3), levelling of the head (6, 1.5), gravity (0, 5).
Estimate worked(const std::string& head) {
  Estimate estimate = two_parameters();
  settle(estimate,
         {from_variances("output noise", {16.0, 9.0}), from_shifts("level of the head", columns(2, {6.0, 1.5}), head),
          from_shifts("gravity", columns(2, {0.0, 5.0}), "site S1")});
  return estimate;
}

TEST(Answer, BudgetSumsToTheCovariance) {
  const Estimate estimate = worked("head R1");
  expect_covariance(estimate.covariance, {52.0, 9.0, 9.0, 36.25});
  ASSERT_EQ(estimate.budget.size(), 3u);
  EXPECT_EQ(estimate.budget[1].variance(0), 36.0);
  EXPECT_EQ(estimate.budget[1].factor(1, 0), 1.5);
}

TEST(Answer, EqualKeysGiveTheCovarianceOfTwoResults) {
  Estimate same = worked("head R1"), other = worked("head R1");
  append(same, worked("head R1"));
  append(other, worked("head R2"));
  // columns: K0, K1 of the first, K0, K1 of the second result
  expect_covariance(same.covariance, {52, 9, 36, 9, 9, 36.25, 9, 27.25, 36, 9, 52, 9, 9, 27.25, 9, 36.25});
  expect_covariance(other.covariance, {52, 9, 0, 0, 9, 36.25, 0, 25, 0, 0, 52, 9, 0, 25, 9, 36.25});
  EXPECT_EQ(same.budget.size(), 3u);
  EXPECT_EQ(other.budget.size(), 4u);
}

TEST(Answer, TheSignOfASharedErrorIsKept) {
  Estimate estimate = two_parameters(), turned = two_parameters();
  settle(estimate, {from_shifts("level", columns(2, {2.0, 1.0}), "R1")});
  settle(turned, {from_shifts("level", columns(2, {-2.0, 1.0}), "R1")});
  append(estimate, turned);
  EXPECT_EQ(estimate.covariance(0, 2), -4.0);
  EXPECT_EQ(estimate.covariance(1, 3), 1.0);
}

TEST(Answer, GradientsCarryTheCovarianceOfTheInputs) {
  Estimate estimate = two_parameters();
  const Matrix gradients = columns(2, {1.0, 0.0, -2.0, 3.0, 0.5, 0.0});  // 2 x 3
  const Matrix inputs = columns(3, {4.0, 1.0, 0.0, 1.0, 9.0, -2.0, 0.0, -2.0, 16.0});
  settle(estimate, {from_gradients("fit", gradients, inputs)});
  // J C J' by hand: var_0 = 4 + 4 x 9 + 16/4 - 4 x 1 + 2 (-2)(0.5)(-2), cov = 3 (1 - 2 x 9 - 0.5 x 2), var_1 = 81
  expect_covariance(estimate.covariance, {44.0, -54.0, -54.0, 81.0});
}

TEST(Answer, DegreesOfFreedomAreWelchAndSatterthwaites) {
  Estimate estimate = two_parameters();
  estimate.parameters[1].degrees_of_freedom = 7.0;
  auto first = from_variances("a", {4.0, 0.0}), second = from_variances("b", {2.0, 0.0});
  first.degrees_of_freedom = {5.0, 5.0};
  second.degrees_of_freedom = {10.0, 10.0};
  settle(estimate, {first, second, from_variances("known", {3.0, 1.0})});
  EXPECT_NEAR(estimate.parameters[0].degrees_of_freedom, 81.0 / (16.0 / 5.0 + 4.0 / 10.0), 1e-12);
  EXPECT_EQ(estimate.parameters[1].degrees_of_freedom, 7.0);  // no line says any of it
}

TEST(Answer, LinesOfOneSourceBecomeOneWithoutMoreColumnsThanParameters) {
  Estimate estimate = two_parameters();
  std::vector<ErrorLine> lines;
  for (int k = 0; k < 5; ++k) lines.push_back(from_shifts("noise", columns(2, {1.0, 0.1 * k})));
  settle(estimate, lines);
  ASSERT_EQ(estimate.budget.size(), 1u);
  EXPECT_EQ(estimate.budget[0].factor.columns, 2u);
  expect_covariance(estimate.covariance, {5.0, 1.0, 1.0, 0.3});
}

TEST(Answer, SmallLinesAreGatheredUnlessAKeyNeedsThem) {
  Estimate estimate = two_parameters();
  settle(estimate, {from_variances("noise", {1.0, 1.0}), from_variances("small", {1e-4, 0.0}),
                    from_variances("smaller", {0.0, 2e-4}), from_shifts("level", columns(2, {1e-2, 1e-2}), "R1")});
  gather_small(estimate);
  ASSERT_EQ(estimate.budget.size(), 3u);
  EXPECT_EQ(estimate.budget[1].key, "R1");
  EXPECT_EQ(estimate.budget[2].source, "all other errors");
  EXPECT_NEAR(estimate.budget[2].variance(1), 2e-4, 1e-18);
  const Matrix sum = covariance_of(estimate.budget, 2);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(sum.values[k], estimate.covariance.values[k], 1e-15);
}

TEST(Answer, AParameterComesAndGoesWithItsRow) {
  Estimate estimate = worked("");
  append_parameter(estimate, {"threshold", "t", Unit(), 3.0, "", 4.0}, "output noise", 0.25);
  ASSERT_EQ(estimate.covariance.rows, 3u);
  EXPECT_EQ(estimate.covariance(2, 2), 0.25);
  EXPECT_EQ(estimate.covariance(0, 2), 0.0);
  EXPECT_EQ(estimate.budget.size(), 3u);
  remove_parameter(estimate, 0);
  expect_covariance(estimate.covariance, {36.25, 0.0, 0.0, 0.25});
  EXPECT_EQ(estimate.parameters[1].name, "threshold");
}

// A finding concerns parameters by their indices: these change with the parameters before.
TEST(Answer, FindingsFollowTheirParameters) {
  Estimate sum = worked(""), part = worked("");
  const auto about = [](std::vector<std::size_t> indices) {
    Finding finding;
    finding.about = std::move(indices);
    return finding;
  };
  for (std::size_t i = 0; i < part.parameters.size(); ++i) part.parameters[i].name += " of the part";
  part.findings = {about({0, 1}), about({0}), about({})};
  append(sum, part);
  ASSERT_EQ(sum.findings.size(), 3u);
  EXPECT_EQ(sum.findings[0].about, (std::vector<std::size_t>{2, 3}));
  remove_parameter(sum, 2);
  ASSERT_EQ(sum.findings.size(), 2u) << "the one about this parameter alone";
  EXPECT_EQ(sum.findings[0].about, std::vector<std::size_t>{2});
  EXPECT_TRUE(sum.findings[1].about.empty());
}

TEST(Answer, ACovarianceThatIsNoneIsADefect) {
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"noise"}, .pattern = "not positive semidefinite"}, [&] {
    from_covariance("noise", columns(2, {1.0, 1.1, 1.1, 1.0}));
  }));
  Estimate estimate = two_parameters();
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"noise"}, .pattern = "one row a parameter"},
                      [&] { settle(estimate, {from_variances("noise", {1.0})}); }));
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"level", "R1"}}, [&] {
    settle(estimate, {from_shifts("level", columns(2, {1.0, 1.0}), "R1"),
                      from_shifts("level", columns(2, {1.0, 1.0, 2.0, 2.0}), "R1")});
  }));
}

TEST(Answer, AnEndlessUncertaintySaysNothingOfTheOthers) {
  Estimate estimate = two_parameters();
  settle(estimate, {from_covariance("noise", columns(2, {INFINITY, 0.0, 0.0, 4.0}))});
  EXPECT_TRUE(std::isinf(estimate.covariance(0, 0)));
  EXPECT_EQ(estimate.covariance(1, 1), 4.0);
  EXPECT_EQ(estimate.covariance(0, 1), 0.0);
}

}  // namespace
}  // namespace tumble
