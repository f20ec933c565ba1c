#include "tumble/exchange/populations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tumble/core/budget.hpp"
#include "tumble/exchange/testing/fleet.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::fleet_result;
using testing::fleet_results;
using testing::FleetModel;

std::vector<TestedUnit> tested(const std::vector<testing::FleetResult>& results) {
  std::vector<TestedUnit> units;
  for (std::size_t i = 0; i < results.size(); ++i)
    units.push_back({results[i].estimate.instrument_serial, std::string(63, '0') + std::to_string(i % 10), false,
                     results[i].estimate});
  return units;
}

Estimate population_of_fleet(const FleetModel& model, const RandomStream& random, std::uint64_t count) {
  return population_of_units("pendulous_accelerometer", "accelerometer_tumble",
                             tested(fleet_results(model, random, count)));
}

double sd_of(const Estimate& estimate, const char* name) {
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
    if (estimate.parameters[i].name == name)
      return estimate.parameters[i].unit.difference_from_si(standard_uncertainty(estimate, i));
  return NAN;
}

TEST(PopulationOfUnits, StatesTheSpreadAndWhatTheMeansShare) {
  const FleetModel model{.spread = 3.0, .shared = 2.0};
  const auto population = population_of_fleet(model, RandomStream(3), 60);
  ASSERT_TRUE(population.population.has_value());
  EXPECT_EQ(population.population->units, 60u);
  EXPECT_EQ(population.parameters.size(), 3u);
  EXPECT_NEAR(population.parameters[0].unit.difference_from_si(unit_to_unit_sd(population, 0)), 12.0, 4.0);  // 3 sd
  bool gravity = false;
  for (const auto& line : population.budget)
    if (line.source == "gravity") {
      gravity = true;
      EXPECT_EQ(line.key, "site");
      // all results have the error whole: so has the mean
      EXPECT_NEAR(population.parameters[1].unit.difference_from_si(line.factor(1, 0)), 6.0, 1.5);
    }
  EXPECT_TRUE(gravity);
  const Matrix sum = covariance_of(population.budget, 3);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(sum.values[i], population.covariance.values[i]);
}

TEST(PopulationOfUnits, DoesNotDependOnTheOrderOfTheResults) {
  auto units = tested(fleet_results({}, RandomStream(5), 12));
  const auto one = population_of_units("m", "accelerometer_tumble", units);
  std::ranges::reverse(units);
  const auto other = population_of_units("m", "accelerometer_tumble", units);
  EXPECT_EQ(one.population->sha256, other.population->sha256);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(one.parameters[k].value, other.parameters[k].value);
}

TEST(PopulationOfUnits, IsReadBackAsItWasWritten) {
  const auto population = population_of_fleet({}, RandomStream(7), 8);
  const auto text = to_json(population);
  const auto read = estimate_from_json(text, "population.json");
  ASSERT_TRUE(read.population.has_value());
  EXPECT_EQ(read.population->sha256, population.population->sha256);
  EXPECT_EQ(read.population->inflation, population.population->inflation);
  EXPECT_EQ(to_json(read), text);
  EXPECT_TRUE(problems_of_prior(read, "pendulous_accelerometer", "accelerometer_tumble").empty());
  EXPECT_EQ(problems_of_prior(read, "triad", "imu_turntable").size(), 2u);
}

TEST(PopulationOfUnits, RefusesFewUnitsAndSaysWhy) {
  auto units = tested(fleet_results({}, RandomStream(5), 6));
  units[5].estimate = units[0].estimate;  // one unit under two serial numbers
  units[4].simulated = true;
  EXPECT_TRUE(refuses(Error::Kind::bad_data,
                      std::vector<Asked>{{.values = {"4", "m", "accelerometer_tumble"}},
                                         {.values = {"U1005"}, .pattern = "the same values as another unit"},
                                         {.values = {"U1004"}, .pattern = "simulated"},
                                         {.values = {"U7"}, .pattern = "made with a prior"}},
                      [&] {
                        population_of_units("m", "accelerometer_tumble", units, {{"U7", "abc", "result_with_prior"}});
                      }));
  EXPECT_TRUE(
      refuses(Error::Kind::bad_data, Asked{.values = {"0", "m", "x"}}, [] { population_of_units("m", "x", {}); }));
}

TEST(PopulationOfUnits, UsesResultsInWhichAParameterIsMissingOrPartOfASum) {
  const RandomStream random(9);
  std::vector<testing::FleetResult> results;
  for (std::uint64_t i = 0; i < 30; ++i)
    results.push_back(fleet_result({.spread = 3.0}, random, i, i % 2,
                                   i % 3 == 0   ? "all"
                                   : i % 3 == 1 ? "no K2"
                                                : "K0 with K2"));
  const auto population = population_of_units("m", "accelerometer_tumble", tested(results));
  ASSERT_EQ(population.parameters.size(), 3u);
  EXPECT_TRUE(population.parameters[0].contains.empty());
  EXPECT_NEAR(population.parameters[2].unit.from_si(population.parameters[2].value), 300.0, 4.0 * 1.0);
  EXPECT_NEAR(population.parameters[0].unit.from_si(population.parameters[0].value), 100.0,
              4.0 * sd_of(population, "K0") / std::sqrt(10.0));
}

TEST(PopulationOfUnits, KeepsTheMeaningThatMostUnitsHave) {
  const RandomStream random(9);
  std::vector<testing::FleetResult> results;
  for (std::uint64_t i = 0; i < 12; ++i)
    results.push_back(fleet_result({}, random, i, 0, i < 3 ? "all" : "K0 with K2"));
  const auto population = population_of_units("m", "accelerometer_tumble", tested(results));
  ASSERT_EQ(population.parameters.size(), 2u);  // K2 is shown by three units only
  EXPECT_EQ(population.parameters[0].contains.size(), 1u);
  // a result whose K0 is K0 alone has another meaning: its own value stays
  const auto other = fleet_result({}, random, 50, 0, "all");
  const auto use = with_population(other.estimate, population);
  ASSERT_TRUE(use.with_prior);
  EXPECT_EQ(use.with_prior->parameters[0].name, "K0");
  EXPECT_TRUE(use.with_prior->parameters[0].contains.empty());
  EXPECT_LE(sd_of(*use.with_prior, "K0"), sd_of(other.estimate, "K0") * (1.0 + 1e-9));
}

TEST(PopulationOfUnits, ListsOutliersAndDoesNotUseThem) {
  const RandomStream random(11);
  auto results = fleet_results({.spread = 1.0}, random, 30);
  const auto clean = population_of_units("m", "accelerometer_tumble", tested(results));
  results[4] = fleet_result({.spread = 1.0, .outside = 40.0}, random, 4, 0);
  const auto found = population_of_units("m", "accelerometer_tumble", tested(results));
  EXPECT_EQ(found.population->units, 29u);
  ASSERT_TRUE(find_table(found, "outliers"));
  EXPECT_EQ(std::get<std::string>(find_table(found, "outliers")->rows[0][0]), "U1004");
  EXPECT_NEAR(unit_to_unit_sd(found, 0), unit_to_unit_sd(clean, 0), 0.3 * unit_to_unit_sd(clean, 0));
}

TEST(PopulationOfUnits, TakesSingularCovariances) {
  auto units = tested(fleet_results({}, RandomStream(13), 9));
  for (auto& unit : units) {  // one private error moves all parameters
    auto& factor = unit.estimate.budget[0].factor;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 1; k < 3; ++k) factor(i, k) = 0.0;
    factor(2, 0) = 0.5 * factor(0, 0);
    unit.estimate.covariance = covariance_of(unit.estimate.budget, 3);
  }
  const auto population = population_of_units("m", "accelerometer_tumble", units);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(standard_uncertainty(population, k)));
  const auto use = with_population(units[0].estimate, population);
  ASSERT_TRUE(use.with_prior);
  EXPECT_TRUE(std::isfinite(sd_of(*use.with_prior, "K0")));
}

TEST(Unfit, NamesWhatCannotBePartOfAPopulation) {
  auto result = fleet_result({}, RandomStream(1), 0, 0).estimate;
  EXPECT_EQ(unfit_for_population(result), "");
  auto with = result;
  with.prior = std::make_shared<const PriorUse>(with_population(result, population_of_fleet({}, RandomStream(1), 8)));
  EXPECT_EQ(unfit_for_population(with), "result_with_prior");
  result.findings.push_back({Finding::Severity::error, "budget_without_factors", {}});
  EXPECT_EQ(unfit_for_population(result), "result_without_factors");
}

std::vector<OccasionResult> occasions() {
  std::vector<OccasionResult> results;
  const RandomStream random(3);
  std::uint64_t n = 0;
  for (int unit = 0; unit < 6; ++unit)
    for (int day = 0; day < 3; ++day)
      for (int turn = 0; turn < 2; ++turn, ++n)
        results.push_back(
            {"U" + std::to_string(unit), std::to_string(n), "2026-11-0" + std::to_string(day + 1),
             n % 4 < 2 ? "T-1" : "T-2", static_cast<double>(n) * 3600.0,
             testing::single_result(5.0 + random.split("unit").normal(unit) +
                                        0.3 * random.split("day").normal(3 * unit + day) + 0.1 * random.normal(n),
                                    0.05)});
  return results;
}

TEST(ComponentsOfResults, NameEachSourceWithItsInterval) {
  const auto found = components_of_results("triad", "bias", occasions());
  const std::vector<std::string> names{"bias_mean", "bias_unit_sd", "bias_day_sd", "bias_rig_sd", "bias_turn_on_sd"};
  ASSERT_EQ(found.parameters.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(found.parameters[i].name, names[i]);
  for (std::size_t i = 1; i < names.size(); ++i) {
    EXPECT_LE(found.parameters[i].lower, found.parameters[i].value);
    EXPECT_GE(found.parameters[i].upper, found.parameters[i].value);
  }
  EXPECT_EQ(to_json(estimate_from_json(to_json(found), "x")), to_json(found));
}

TEST(ComponentsOfResults, AreOfOneQuantity) {
  auto results = occasions();
  const auto alone = components_of_results("m", "bias", results);
  for (int i = 0; i < 4; ++i) {
    auto other = results[static_cast<std::size_t>(i)];
    other.serial = "A" + std::to_string(i), other.estimate.parameters[0].unit = Unit::parse("kg");
    results.push_back(other);
  }
  const auto mixed = components_of_results("m", "bias", results);
  EXPECT_EQ(mixed.parameters[1].value, alone.parameters[1].value);
  ASSERT_TRUE(find_table(mixed, "left_out"));
  EXPECT_EQ(find_table(mixed, "left_out")->rows.size(), 4u);
}

TEST(ComponentsOfResults, MergeWhatCannotBeSeparatedAndSaySo) {
  const auto names_of = [](const Estimate& estimate) {
    std::string text;
    for (const auto& parameter : estimate.parameters) text += parameter.name + " ";
    for (const auto& finding : estimate.findings) text += finding.code + " ";
    return text;
  };
  auto results = occasions();
  for (auto& one : results) one.rig = "T-1";
  EXPECT_EQ(names_of(components_of_results("m", "bias", results)),
            "bias_mean bias_unit_sd bias_day_sd bias_turn_on_sd one_rig ");
  for (auto& one : results) one.rig = one.serial, one.day = "2026-11-01";
  EXPECT_EQ(names_of(components_of_results("m", "bias", results)),
            "bias_mean bias_unit_and_day_sd bias_turn_on_sd one_day_a_unit rig_not_separated ");
  for (std::size_t i = 0; i < results.size(); ++i) results[i].day = std::to_string(i), results[i].rig = "";
  EXPECT_EQ(names_of(components_of_results("m", "bias", results)),
            "bias_mean bias_unit_sd bias_day_and_turn_on_sd one_result_a_day rig_not_known ");
  std::vector<OccasionResult> single;
  for (std::size_t i = 0; i < results.size(); i += 6) single.push_back(results[i]);
  EXPECT_EQ(names_of(components_of_results("m", "bias", single)),
            "bias_mean bias_unit_day_and_turn_on_sd one_result_a_unit ");
  single.resize(3);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"m", "bias", "3"}, .pattern = "at least four results"},
                      [&] { components_of_results("m", "bias", single); }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"m", "bais", "0", "bias"}},
                      [&] { components_of_results("m", "bais", results); }));
}

}  // namespace
}  // namespace tumble
