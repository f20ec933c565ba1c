#include "tumble/reduce/with_prior.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/answer.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

Parameter parameter(const char* name, double value, std::vector<Parameter::Contained> contains = {}) {
  Parameter out;
  out.name = name;
  out.value = value;
  out.contains = std::move(contains);
  return out;
}

Matrix covariance(double a, double b, double correlation) {
  Matrix c(2, 2);
  c(0, 0) = a * a, c(1, 1) = b * b, c(0, 1) = c(1, 0) = correlation * a * b;
  return c;
}

/// Two parameters, K0 and K2, of 21 units.
Estimate population(const std::vector<ErrorLine>& more = {}) {
  Estimate out;
  out.instrument_model = "m";
  out.parameters = {parameter("K0", 10.0), parameter("K2", 3.0)};
  std::vector<ErrorLine> lines{from_covariance("unit to unit", covariance(2.0, 1.0, 0.4))};
  lines.insert(lines.end(), more.begin(), more.end());
  settle(out, lines);
  out.population = PopulationFacts{"accelerometer_tumble", "abc", 21, 5.0, 1.0};
  return out;
}

Estimate own_result(std::vector<Parameter> parameters, const std::vector<ErrorLine>& lines) {
  Estimate out;
  out.parameters = std::move(parameters);
  settle(out, lines);
  return out;
}

// The normal equations of a fit whose last rows say theta = mean with covariance P: (P^-1 + A' C^-1 A)^-1 (...).
TEST(WithPopulation, IsTheFitWithThePopulationAsMoreRows) {
  const auto prior = population();
  const auto own = own_result({parameter("K0", 11.5, {{"K2", Unit(), -0.75}}), parameter("K2", 2.0)},
                              {from_covariance("noise", covariance(1.0, 1.5, -0.3))});
  const auto use = with_population(own, prior);
  ASSERT_TRUE(use.with_prior);
  Matrix a = identity(2);
  a(0, 1) = -0.75;
  const Matrix weight = inverse_symmetric(covariance(1.0, 1.5, -0.3)), inverse = inverse_symmetric(prior.covariance);
  const Matrix expected = inverse_symmetric(inverse + transposed(a) * weight * a);
  const std::vector<double> mean{10.0, 3.0}, y{11.5, 2.0};
  const auto values = expected * scaled_sum(inverse * mean, 1.0, transposed(a) * (weight * y));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(use.with_prior->parameters[i].value, values[i], 1e-8) << i;
    for (std::size_t j = 0; j < 2; ++j) EXPECT_NEAR(use.with_prior->covariance(i, j), expected(i, j), 1e-8) << i << j;
  }
  EXPECT_TRUE(use.with_prior->parameters[0].contains.empty()) << "the population separates the two";
}

TEST(WithPopulation, CarriesTermsThatTheScheduleDoesNotShow) {
  const auto own = own_result({parameter("K0", 13.0)}, {from_variances("noise", {1.0})});
  const auto use = with_population(own, population());
  ASSERT_TRUE(use.with_prior);
  ASSERT_EQ(use.with_prior->parameters.size(), 2u);
  EXPECT_EQ(use.with_prior->parameters[1].name, "K2");
  // K0 is 3 above the mean; of that 0.4 x 1/2 x 4/5 goes to K2
  EXPECT_NEAR(use.with_prior->parameters[0].value, 10.0 + 3.0 * 4.0 / 5.0, 1e-8);
  EXPECT_NEAR(use.with_prior->parameters[1].value, 3.0 + 0.4 * 2.0 * 1.0 / 5.0 * 3.0, 1e-8);
  EXPECT_NEAR(use.with_prior->covariance(1, 1), 1.0 - 0.8 * 0.8 / 5.0, 1e-8);
}

TEST(WithPopulation, CorrectsOtherParametersByWhatIsKnownOfTheirErrors) {
  // K0 and K9 share an error of sd 1 each
  const auto own = own_result({parameter("K9", 7.0), parameter("K0", 14.0)},
                              {from_shifts("level", Matrix(2, 1, 1.0)), from_variances("noise", {0.25, 1e-12})});
  const auto use = with_population(own, population());
  ASSERT_TRUE(use.with_prior);
  EXPECT_EQ(use.with_prior->parameters[0].name, "K9");
  EXPECT_NEAR(use.with_prior->parameters[0].value, 7.0 - 4.0 / 5.0, 1e-8) << "of the 4 from the mean 1/5 is the level";
  EXPECT_NEAR(use.with_prior->covariance(0, 0), 0.25 + 4.0 / 5.0, 1e-8);
}

TEST(WithPopulation, ErrorsThatBothShareAreAFloor) {
  Matrix level(2, 1);
  level(0, 0) = 3.0;
  const auto prior = population({from_shifts("level", level, "T-1")});
  const auto on = [&](const char* key) {
    const auto own = own_result({parameter("K0", 13.0)},
                                {from_variances("noise", {1.0}), from_shifts("level", Matrix(1, 1, 3.0), key)});
    return *with_population(own, prior).with_prior;
  };
  const auto same = on("T-1"), other = on("T-2");
  // same table: y - mean has variance 4 + 1, and the level is in the value as in the mean
  EXPECT_NEAR(same.parameters[0].value, 10.0 + 3.0 * 4.0 / 5.0, 1e-8);
  EXPECT_NEAR(same.covariance(0, 0), 4.0 / 5.0 + 9.0, 1e-8);
  EXPECT_NEAR(other.covariance(0, 0), 13.0 * 10.0 / 23.0, 1e-8);
  EXPECT_EQ(same.budget.size(), 3u);
}

TEST(WithPopulation, IsNotUsedForAnAlien) {
  const auto at = [&](double value, double freedom) {
    auto own = own_result({parameter("K0", value), parameter("K2", 3.0)}, {from_variances("noise", {1.0, 1.0})});
    own.parameters[0].degrees_of_freedom = freedom;
    return with_population(own, population());
  };
  EXPECT_TRUE(at(13.0, INFINITY).with_prior);
  const auto alien = at(10.0 + 10.0 * std::sqrt(5.0), INFINITY);
  EXPECT_FALSE(alien.with_prior);
  EXPECT_LT(alien.belongs, 1e-6);
  const auto own = own_result({parameter("K0", 32.0), parameter("K2", 3.0)}, {from_variances("noise", {1.0, 1.0})});
  EXPECT_EQ(about_prior(own, alien)[0].code, "unit_not_of_population");
  EXPECT_TRUE(with_population(own, population(), true).with_prior) << "assumed values are not judged";
}

// The other part is (0.01/2)^2 and (2/100)^2 of the variance. The freedom grows by twice that: by 3.5e-4 of 7, and by
// 0.016 of 20.
TEST(WithPopulation, DegreesOfFreedomAreOfThePartThatCounts) {
  const auto at = [&](double sd) {
    auto own = own_result({parameter("K0", 11.0)}, {from_variances("noise", {sd * sd})});
    own.parameters[0].degrees_of_freedom = 7.0;
    return with_population(own, population()).with_prior->parameters[0].degrees_of_freedom;
  };
  EXPECT_NEAR(at(0.01), 7.0, 1e-3);
  EXPECT_NEAR(at(100.0), 20.0, 0.02);
}

TEST(WithPopulation, RefusesOtherDimensions) {
  auto own = own_result({parameter("K0", 11.0)}, {from_variances("noise", {1.0})});
  own.parameters[0].unit = Unit::parse("deg/h");
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.values = {"K0", "deg/h"}}, [&] { with_population(own, population()); }));
}

// To the three decimals of the table in docs/equations/populations.md: half of the last, and 1e-4.
TEST(ConditionalCoverage, IsThatOfTheChapter) {
  const double known[2][5]{{0.961, 0.950, 0.916, 0.856, 0.768}, {0.994, 0.962, 0.780, 0.410, 0.110}};
  for (int c = 0; c < 5; ++c) {
    EXPECT_NEAR(conditional_coverage(3.0, c), known[0][c], 6e-4) << c;
    EXPECT_NEAR(conditional_coverage(1.0, c), known[1][c], 6e-4) << c;
  }
}

TEST(PriorTable, SaysHowMuchIsGainedAndWhatIsPromised) {
  const auto own = own_result({parameter("K0", 13.0)}, {from_variances("noise", {1.0})});
  const auto use = with_population(own, population());
  const auto table = prior_table(own, use);
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_NEAR(std::get<double>(table.rows[0][1]), 2.0, 1e-9);
  EXPECT_NEAR(std::get<double>(table.rows[0][2]), std::sqrt(0.8), 5e-4);  // three digits
  EXPECT_EQ(std::get<std::string>(table.rows[1][1]), "not shown");
}

}  // namespace
}  // namespace tumble
