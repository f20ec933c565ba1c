#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tumble/core/budget.hpp"
#include "tumble/core/testing/asserts.hpp"
#include "tumble/exchange/comparison.hpp"
#include "tumble/math/random.hpp"
#include "tumble/report/testing/example_estimate.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

Matrix column(std::initializer_list<double> values) {
  Matrix matrix(values.size(), 1);
  std::ranges::copy(values, matrix.values.begin());
  return matrix;
}

/// Two parameters [m]: private errors of 3 and 4, and one shared by all results of one head.
NamedResult result(const std::string& name, double first, double second, double shared = 1.0,
                   const std::string& key = "C-77") {
  Estimate estimate;
  estimate.method = "made_up", estimate.instrument_model = "gyro", estimate.instrument_serial = "1";
  const Unit metre = Unit::parse("m");
  estimate.parameters = {{"a", "a", metre, first, ""}, {"b", "b", metre, second, ""}};
  Matrix own(2, 2);
  own(0, 0) = 3.0, own(1, 1) = 4.0;
  estimate.budget = {{"noise", "", own}, {"index zero", key, column({12.0 * shared, -5.0 * shared})}};
  estimate.covariance = covariance_of(estimate.budget, 2);
  estimate.provenance.inputs = {{name, name}};
  return {name, estimate};
}

TEST(Compare, SubtractsWhatBothShare) {
  const auto comparison = compare({result("1", 10.0, 0.0), result("2", 14.0, 1.0)});
  const auto& [first, second] = std::pair{comparison.pairs[0].differences[0], comparison.pairs[0].differences[1]};
  EXPECT_NEAR(first.sd, std::sqrt(18.0), 1e-13);  // 153 + 153 - 288: the rounding of the roots grows by 17
  EXPECT_NEAR(second.sd, std::sqrt(32.0), 1e-13);
  EXPECT_DOUBLE_EQ(first.shared_covariance, 144.0);
  EXPECT_NEAR(first.e_n, 4.0 / (1.959963984540054 * std::sqrt(18.0)), 1e-12);
  EXPECT_TRUE(comparison.findings.empty());
  // Independent with the shared error gone: (4/sqrt 18)^2 + (1/sqrt 32)^2.
  EXPECT_NEAR(comparison.pairs[0].chi_square, 16.0 / 18.0 + 1.0 / 32.0, 1e-12);
  EXPECT_EQ(comparison.pairs[0].rank, 2u);
}

TEST(Compare, OfOtherEquipmentSharesNothing) {
  const auto comparison = compare({result("1", 10.0, 0.0), result("2", 14.0, 1.0, 1.0, "C-78")});
  EXPECT_DOUBLE_EQ(comparison.pairs[0].differences[0].sd, std::sqrt(18.0 + 288.0));
  EXPECT_EQ(comparison.pairs[0].differences[0].shared_covariance, 0.0);
}

TEST(Compare, SimulationsOfTwoSeedsShareNothing) {
  auto one = result("1", 10.0, 0.0), two = result("2", 14.0, 1.0);
  one.estimate.provenance.seed = 1, two.estimate.provenance.seed = 2;
  const auto comparison = compare({one, two});
  EXPECT_DOUBLE_EQ(comparison.pairs[0].differences[0].sd, std::sqrt(18.0 + 288.0));
  EXPECT_TRUE(has_finding(comparison.findings, "simulated_apart"));
  two.estimate.provenance.seed = 1;
  EXPECT_FALSE(has_finding(compare({one, two}).findings, "simulated_apart"));
}

TEST(Compare, AnErrorWithTheOtherSignAdds) {
  const auto comparison = compare({result("1", 0.0, 0.0), result("2", 0.0, 0.0, -1.0)});
  EXPECT_DOUBLE_EQ(comparison.pairs[0].differences[0].sd, std::sqrt(18.0 + 4.0 * 144.0));
}

TEST(Compare, OfOneResultWithItselfHasNoUncertaintyLeft) {
  auto one = result("1", 10.0, 0.0);
  one.estimate.budget[0].key = "the very same";
  const auto comparison = compare({one, one});
  EXPECT_EQ(comparison.pairs[0].differences[0].sd, 0.0);
  EXPECT_TRUE(std::isnan(comparison.pairs[0].differences[0].e_n));
  EXPECT_EQ(comparison.pairs[0].rank, 0u);
  EXPECT_TRUE(has_finding(comparison.findings, "results_of_one_recording"));
}

TEST(Compare, AChangeWithoutUncertaintyIsSignificant) {
  auto one = result("1", 10.0, 0.0), two = result("2", 10.5, 0.0);
  one.estimate.budget[0].key = two.estimate.budget[0].key = "the very same";
  const auto shared = compare({one, two});
  EXPECT_EQ(shared.pairs[0].differences[0].e_n, INFINITY);
  EXPECT_TRUE(std::isnan(shared.pairs[0].differences[1].e_n));
  EXPECT_EQ(shared.pairs[0].probability, 0.0);
  EXPECT_TRUE(has_finding(shared.findings, "change_without_uncertainty"));
  EXPECT_NE(to_text(shared).find("inf *"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(to_json(shared))["pairs"][0]["differences"][0]["e_n"].is_null());
  for (auto* none : {&one.estimate, &two.estimate}) none->budget.clear(), none->covariance = Matrix(2, 2);
  EXPECT_EQ(compare({two, one}).pairs[0].differences[0].e_n, -INFINITY);
}

TEST(Compare, ASimulationSharesNothingWithAMeasurement) {
  auto one = result("1", 10.0, 0.0);
  one.estimate.provenance.seed = 1;
  const auto comparison = compare({one, result("2", 14.0, 1.0)});
  EXPECT_EQ(comparison.pairs[0].differences[0].shared_covariance, 0.0);
  EXPECT_TRUE(has_finding(comparison.findings, "simulated_once"));
}

TEST(Compare, HasFivePerCentOfFalseAlarms) {
  // 4000 pairs whose errors are drawn as the budget says: 200 +- 4 sqrt(190) lie beyond 1, for each parameter.
  const RandomStream random(7);
  const Estimate plain = result("1", 0.0, 0.0).estimate;
  int alarms = 0, together = 0;
  for (std::uint64_t n = 0; n < 4000; ++n) {
    const auto draw = [&](std::uint64_t k) { return random.split(n).normal(k); };
    const double shared = draw(0);
    const auto comparison = compare({result("1", 3.0 * draw(1) + 12.0 * shared, 4.0 * draw(2) - 5.0 * shared),
                                     result("2", 3.0 * draw(3) + 12.0 * shared, 4.0 * draw(4) - 5.0 * shared)});
    alarms += std::abs(comparison.pairs[0].differences[0].e_n) > 1.0;
    together += comparison.pairs[0].probability < 0.05;
  }
  EXPECT_NEAR(alarms, 200, 4.0 * std::sqrt(190.0));
  EXPECT_NEAR(together, 200, 4.0 * std::sqrt(190.0));
}

TEST(Compare, OfFewDegreesOfFreedomTakesStudentsT) {
  auto one = result("1", 0.0, 0.0), other = result("2", 1.0, 0.0, 1.0, "C-78");
  // Only the private 3 is estimated; u_1^4/nu_1 is that of the private part: nu_1 = nu (u_1/3)^4.
  one.estimate.parameters[0].degrees_of_freedom = 5.0 * std::pow(153.0 / 9.0, 2);
  const auto shared = compare({one, result("2", 1.0, 0.0)}).pairs[0].differences[0];
  EXPECT_NEAR(shared.degrees_of_freedom, 18.0 * 18.0 / (81.0 / 5.0), 1e-9);
  EXPECT_GT(shared.expanded / shared.sd, 2.08);  // t of 20 degrees of freedom: 2.086
  EXPECT_LT(shared.expanded / shared.sd, 2.09);
}

TEST(Compare, WithoutDegreesOfFreedomTakesOne) {
  for (const double none : {0.0, -3.0}) {
    auto one = result("1", 0.0, 0.0);
    one.estimate.parameters[0].degrees_of_freedom = none;
    EXPECT_EQ(compare({one, result("2", 1.0, 0.0)}).pairs[0].differences[0].degrees_of_freedom, 1.0);
  }
}

TEST(Compare, TakesTheHalvesOfIntervalsThatFaceEachOther) {
  auto one = result("1", 1.0, 0.0), other = result("2", 2.0, 0.0, 1.0, "C-78");
  one.estimate.parameters[0].lower = -9.0, one.estimate.parameters[0].upper = 1.3;
  other.estimate.parameters[0].lower = 1.6, other.estimate.parameters[0].upper = 90.0;
  EXPECT_NEAR(compare({one, other}).pairs[0].differences[0].expanded, 0.5, 1e-12);
}

TEST(Compare, OfThreeAlsoComparesTheLastWithTheFirst) {
  const auto comparison = compare({result("1", 0.0, 0.0), result("2", 1.0, 0.0), result("3", 2.0, 0.0)});
  ASSERT_EQ(comparison.pairs.size(), 3u);
  EXPECT_EQ(comparison.pairs[2].earlier, 0u);
  EXPECT_EQ(comparison.pairs[2].differences[0].difference, 2.0);
  const auto figures = figures_of(comparison);
  ASSERT_EQ(figures.size(), 2u);
  EXPECT_EQ(figures[0].series[0].x, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_FALSE(to_svg(figures[0]).empty());
}

TEST(Compare, DrawsAParameterOverUnitsWithGaps) {
  auto without = result("2", 1.0, 5.0), seconds = result("3", 2.0, 6.0);
  without.estimate.parameters[0].name = "c";
  seconds.estimate.parameters[0].unit = Unit::parse("s");
  const auto figures = figures_of_units({result("1", 0.5, 4.0), without, seconds});
  ASSERT_EQ(figures.size(), 3u);  // a, b, and c of the second alone
  const auto& a = figures[0].series[0];
  EXPECT_EQ(a.x, (std::vector{1.0, 2.0, 3.0}));
  EXPECT_EQ(a.y[0], 0.5);
  EXPECT_TRUE(std::isnan(a.y[1]) && std::isnan(a.y[2]) && std::isnan(a.lower[2]));
  EXPECT_NEAR(a.upper[0] - a.y[0], 1.959964 * std::sqrt(153.0), 1e-5);
  EXPECT_EQ(figures[1].series[0].y, (std::vector{4.0, 5.0, 6.0}));
  EXPECT_EQ(figures[2].series[0].y[1], 1.0);
}

TEST(Compare, RefusesOtherDimensionsAndNothingInCommon) {
  auto other = result("2", 1.0, 0.0);
  other.estimate.parameters[0].unit = Unit::parse("s");
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"a", "m", "1", "s", "2"}}, [&] {
    compare({result("1", 0.0, 0.0), other});
  }));
  other.estimate.parameters[0].name = "c", other.estimate.parameters[1].name = "d";
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"1", "2"}, .pattern = "in common"}, [&] {
    compare({result("1", 0.0, 0.0), other});
  }));
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.pattern = "two results or more"},
                      [&] { compare({result("1", 0.0, 0.0)}); }));
}

TEST(Compare, OtherUnitsOfOneDimensionAreOneQuantity) {
  auto other = result("2", 14.0, 1.0);
  other.estimate.parameters[0].unit = Unit::parse("km");
  const auto one = compare({result("1", 10.0, 0.0), other}).pairs[0].differences[0];
  EXPECT_EQ(one.difference, 4.0);
  EXPECT_EQ(one.unit.text(), "m");
}

TEST(Compare, WarnsOfOtherInstrumentsAndUnlikeSources) {
  auto other = result("2", 1.0, 0.0);
  other.estimate.instrument_serial = "2", other.estimate.instrument_model = "dtg", other.estimate.method = "another";
  other.estimate.budget[1].factor = Matrix(2, 2, 1.0);
  other.estimate.parameters[1].name = "c";
  const auto comparison = compare({result("1", 0.0, 0.0), other});
  for (const char* code : {"results_of_two_serials", "results_of_two_models", "results_of_two_methods",
                           "shared_source_differs", "parameters_of_one_result"})
    EXPECT_TRUE(has_finding(comparison.findings, code)) << code;
}

TEST(Compare, SkipsWhatOneResultDoesNotKnow) {
  auto other = result("2", NAN, 0.0);
  const auto comparison = compare({result("1", 0.0, 0.0), other});
  ASSERT_EQ(comparison.pairs[0].differences.size(), 1u);
  EXPECT_EQ(comparison.pairs[0].differences[0].parameter, "b");
}

TEST(Compare, JsonIsInTheUnitsOfTheParameters) {
  Estimate one = testing::estimate(), other = testing::estimate();
  other.parameters[7].value += si(0.2, "deg/h");
  const auto json = nlohmann::json::parse(to_json(compare({{"1", one}, {"2\xff", other}})));
  const auto& bias = json["pairs"][0]["differences"][7];
  EXPECT_EQ(bias["parameter"], "bias");
  EXPECT_NEAR(bias["difference"].get<double>(), 0.2, 1e-12);
  EXPECT_NEAR(bias["e_n"].get<double>() * bias["expanded95"].get<double>(), 0.2, 1e-12);
}

TEST(Compare, TextMarksWhatChanged) {
  const auto text = to_text(compare({result("1", 0.0, 0.0), result("2", 90.0, 0.0)}));
  EXPECT_NE(text.find("1 -> 2"), std::string::npos);
  EXPECT_NE(text.find(" *"), std::string::npos);
}

}  // namespace
}  // namespace tumble
