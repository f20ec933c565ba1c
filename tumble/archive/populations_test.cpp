#include "tumble/archive/populations.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "tumble/archive/deposit.hpp"
#include "tumble/archive/testing/samples.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/exchange/testing/fleet.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/reduce/with_prior.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

constexpr const char* model = "pendulous_accelerometer";

/// An archive of a fleet, on SQLite: the same queries serve PostgreSQL.
class PopulationArchive : public ::testing::Test {
 protected:
  PopulationArchive() : address_(folder_.file("lab.db")) { make_archive(address_, {}, testing::sample_act()); }

  Archive open() const { return Archive(address_); }

  static ResultDeposit deposit_of(const Estimate& estimate, const std::string& day = "2026-11-01") {
    return {.json = to_json(estimate), .file = "result.json", .ended = day + "T09:00:00Z"};
  }

  Deposited put(std::vector<ResultDeposit> results, const std::string& why = {}) const {
    Archive archive = open();
    Deposit deposit;
    deposit.results = std::move(results);
    return put_in(archive, deposit, testing::sample_act(why));
  }

  void put_fleet(std::uint64_t units) const {
    std::vector<ResultDeposit> results;
    for (const auto& one : testing::fleet_results({}, random_, units)) results.push_back(deposit_of(one.estimate));
    put(std::move(results));
  }

  ScratchFolder folder_;
  std::string address_;
  RandomStream random_{61};
};

TEST_F(PopulationArchive, HasOneResultOfEachUnit) {
  put_fleet(8);
  const auto first = population_of(open(), {model, "accelerometer_tumble"});
  EXPECT_EQ(first.population->units, 8u);
  put_fleet(8);  // the same again
  auto later = testing::fleet_result({}, random_.split("later"), 0, 0).estimate;
  put({deposit_of(later, "2026-11-20")});  // a unit comes back
  const auto second = population_of(open(), {model});
  EXPECT_EQ(second.population->sha256, first.population->sha256);
  EXPECT_EQ(second.provenance.inputs.size(), 8u);
  const auto without = population_of(open(), {model, "", "U1003"});
  EXPECT_EQ(without.population->units, 7u);
  EXPECT_NE(without.population->sha256, first.population->sha256);
}

TEST_F(PopulationArchive, DoesNotUseResultsWithAPriorOrReplacedOnes) {
  put_fleet(8);
  const auto population = population_of(open(), {model});
  auto result = testing::fleet_result({}, random_, 50, 0).estimate;
  result.prior = std::make_shared<const PriorUse>(with_population(result, population));
  put({deposit_of(result)});
  const auto same = population_of(open(), {model});
  EXPECT_EQ(same.population->sha256, population.population->sha256);
  const auto* left_out = find_table(same, "left_out");
  ASSERT_TRUE(left_out);
  EXPECT_EQ(std::get<std::string>(left_out->rows[0][0]), "U1050");
  EXPECT_EQ(std::get<std::string>(left_out->rows[0][1]), "made with a prior");
  // a correction counts in place of what it replaces
  const auto wrong = testing::fleet_result({.outside = 30.0}, random_, 60, 0).estimate;
  const auto done = put({deposit_of(wrong)});
  auto correction = deposit_of(testing::fleet_result({}, random_, 60, 0).estimate);
  correction.corrects = done.result_ids.at(0);
  put({correction}, "wrong fixture");
  const auto corrected = population_of(open(), {model});
  EXPECT_EQ(corrected.population->units, 9u);
  EXPECT_FALSE(find_table(corrected, "outliers"));
}

TEST_F(PopulationArchive, SaysWhichModelsAndMethodsThereAre) {
  put_fleet(6);
  auto other = testing::fleet_result({}, random_, 0, 0).estimate;
  other.method = "accelerometer_four_position";
  put({deposit_of(other)});
  const auto input = Error::Kind::bad_input;
  EXPECT_TRUE(refuses(input, Asked{.values = {"pendulus_accelerometer", "pendulous_accelerometer"}},
                      [&] { population_of(open(), {"pendulus_accelerometer"}); }));
  EXPECT_TRUE(refuses(input, Asked{.values = {model, "accelerometer_four_position or --method accelerometer_tumble"}},
                      [&] { population_of(open(), {model}); }));
  EXPECT_TRUE(refuses(
      input, Asked{.values = {"sdof_gyro_static", model, "accelerometer_four_position, accelerometer_tumble"}}, [&] {
        population_of(open(), {model, "sdof_gyro_static"});
      }));
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"1", model, "accelerometer_four_position"}}, [&] {
    population_of(open(), {model, "accelerometer_four_position"});
  }));
}

TEST_F(PopulationArchive, GivesComponentsOfAllResults) {
  std::vector<ResultDeposit> results;
  for (std::uint64_t unit = 0; unit < 5; ++unit)
    for (std::uint64_t day = 0; day < 3; ++day)
      for (std::uint64_t turn = 0; turn < 2; ++turn) {
        auto result = testing::single_result(static_cast<double>(unit) + 0.3 * random_.normal(10 * unit + day) +
                                                 0.1 * random_.split("turn").normal(100 * unit + 10 * day + turn),
                                             0.05, "T-1", 0.1);
        result.instrument_model = "triad", result.instrument_serial = "A-" + std::to_string(unit);
        const std::string equipment = day % 2 == 0 ? "T-1" : "T-2";
        result.provenance.plans.push_back(
            {"plan.toml", "abc", "[rig]\nkind = \"rate_table\"\nequipment = \"" + equipment + "\"\n"});
        results.push_back(deposit_of(result, "2026-11-0" + std::to_string(day + 1)));
      }
  put(std::move(results));
  const auto found = components_of(open(), {"triad"}, "bias");
  ASSERT_EQ(found.parameters.size(), 5u);
  EXPECT_EQ(found.parameters[3].name, "bias_rig_sd");
  EXPECT_EQ(found.parameters[4].name, "bias_turn_on_sd");
  // 15 pairs give the sd to 0.1/sqrt(30): four of them, and less than the 0.013 by which the stated 0.05 lowers it.
  EXPECT_NEAR(found.parameters[4].unit.from_si(found.parameters[4].value), 0.1, 0.08);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.values = {"triad", "bais", "bias"}},
                      [&] { components_of(open(), {"triad"}, "bais"); }));
}

}  // namespace
}  // namespace tumble
